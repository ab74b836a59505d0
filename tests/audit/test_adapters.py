"""Pitfalls of engines that sit in their adapters' calls: made again with the real engine, the audit must name them."""

from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest
import realitygap_engines as engines
from realitygap.audit.audit import groups
from realitygap_engines.model.robot import Array


def fails(engine: str, name: str) -> None:
    """The audit's check of that name fails."""
    check = next(check for group in groups().values() for check in group if check.property == name)
    assert check.row(engines.load(engine)).verdict == "failed"


def test_a_missing_inertia_flag_of_pybullet(monkeypatch: pytest.MonkeyPatch) -> None:
    pybullet = pytest.importorskip("pybullet")
    monkeypatch.setattr(pybullet, "URDF_USE_INERTIA_FROM_FILE", 0)
    fails("pybullet", "tree: mass matrix")


def test_a_stale_file_cache_of_pybullet(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """In one client, a URDF rewritten at the same path is not read again while the cache is on."""
    pybullet = pytest.importorskip("pybullet")
    module = pytest.importorskip("realitygap_engines.pybullet")
    client = pybullet.connect(pybullet.DIRECT)
    set_parameter, disconnect = pybullet.setPhysicsEngineParameter, pybullet.disconnect

    def keeping_the_cache(**parameters: Any) -> None:
        set_parameter(**{**parameters, "enableFileCaching": 1})

    monkeypatch.setattr(pybullet, "setPhysicsEngineParameter", keeping_the_cache)
    monkeypatch.setattr(pybullet, "connect", lambda _: client)
    monkeypatch.setattr(pybullet, "disconnect", lambda _: pybullet.resetSimulation(physicsClientId=client))
    monkeypatch.setattr(module.tempfile, "TemporaryDirectory", lambda: nullcontext(str(tmp_path)))
    fails("pybullet", "a changed model is read anew")
    disconnect(client)


def test_a_second_client_of_pybullet_without_its_id(monkeypatch: pytest.MonkeyPatch) -> None:
    pybullet = pytest.importorskip("pybullet")
    step = pybullet.stepSimulation
    monkeypatch.setattr(pybullet, "stepSimulation", lambda **_: step())
    fails("pybullet", "two simulations at once")


def test_mujocos_angular_velocity_left_in_local_axes(monkeypatch: pytest.MonkeyPatch) -> None:
    module = pytest.importorskip("realitygap_engines.mujoco")

    def read_as_it_is(pose: Array, velocity: Array, base: Array) -> None:
        base[:7], base[7:] = pose, velocity

    monkeypatch.setattr(module, "read_base", read_as_it_is)
    fails("mujoco", "tree: state set and read")


def test_darts_silence_about_an_effort_that_is_not_a_number(monkeypatch: pytest.MonkeyPatch) -> None:
    module = pytest.importorskip("realitygap_engines.dart")
    monkeypatch.setattr(module, "isfinite", lambda _: True)
    fails("dart", "a blow-up is seen")


def test_drakes_default_contact_stiffness(monkeypatch: pytest.MonkeyPatch) -> None:
    module = pytest.importorskip("realitygap_engines.drake")
    monkeypatch.setattr(module, "RIGID", 1e4)
    fails("drake", "block: resting height")


def test_drakes_harmonic_mean_of_friction(monkeypatch: pytest.MonkeyPatch) -> None:
    module = pytest.importorskip("realitygap_engines.drake")
    real = module.CoulombFriction
    monkeypatch.setattr(module, "CoulombFriction", lambda a, b: real(2 / (1 / a + 1), 2 / (1 / b + 1)))
    fails("drake", "block: stopping distance")


ode = pytest.mark.skipif("ode" not in engines.available(), reason="ode is not installed")


@ode
@pytest.mark.parametrize(
    ("function", "flag", "name"),
    [
        ("dWorldSetAutoDisableFlag", 1, "no sleep: slow motion"),
        ("dBodySetGyroscopicMode", 0, "tree: 10 ms under constant effort"),
    ],
)
def test_odes_defaults(monkeypatch: pytest.MonkeyPatch, function: str, flag: int, name: str) -> None:
    library = pytest.importorskip("realitygap_engines.ode.robot").ode
    real = getattr(library, function)
    monkeypatch.setattr(library, function, lambda owner, _: real(owner, flag))
    fails("ode", name)
