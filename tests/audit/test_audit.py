"""The audit passes on the engines as they are, judges a team's robot, and says what is wrong with its input."""

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import realitygap_engines as engines
from realitygap.audit import Certificate, Proof, audit, certify
from realitygap.audit.audit import groups
from realitygap.audit.check import Check, largest
from realitygap.audit.dynamics import checks_of
from realitygap.audit.machines import random_state, tree, velocities
from realitygap.audit.oracle import Oracle
from realitygap.audit.robot import load_robot
from realitygap.files.errors import InputError
from realitygap_engines import Capability, Physics, Simulation
from realitygap_engines.model.robot import Link, Model
from realitygap_engines.model.urdf import write_urdf


def inertial(mass: float, moments: tuple[float, float, float], origin: str = "") -> str:
    ixx, iyy, izz = moments
    return (
        f'<inertial>{origin}<mass value="{mass}"/>'
        f'<inertia ixx="{ixx}" iyy="{iyy}" izz="{izz}" ixy="1e-5" ixz="0" iyz="-5e-6"/></inertial>'
    )


BASE = inertial(2.0, (0.01, 0.01, 0.01))
ROBOT = f"""
<robot name="arm">
  <link name="base">{BASE}<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0.1 0.2" rpy="0.3 0.2 0.1"/><axis xyz="0 1 0"/>
    <limit lower="-0.1" upper="0.1" effort="1" velocity="1"/><dynamics damping="0.1" friction="0.2"/></joint>
  <link name="upper">{inertial(0.4, (2e-3, 2e-3, 1e-3), '<origin xyz="0 0 -0.1" rpy="0.4 0 0.2"/>')}</link>
  <joint name="weld" type="fixed"><parent link="upper"/><child link="camera"/>
    <origin xyz="0.05 0 -0.2" rpy="0 0.7 0"/></joint>
  <link name="camera">{inertial(0.1, (1e-4, 2e-4, 2e-4), '<origin xyz="0.01 0 0"/>')}</link>
  <joint name="slide" type="prismatic"><parent link="camera"/><child link="tool"/><origin xyz="0.1 0 0"/>
    <axis xyz="1 0 1"/><limit lower="0" upper="0.2" effort="5" velocity="1"/></joint>
  <link name="tool">{inertial(0.2, (3e-4, 3e-4, 3e-4))}</link>
  <joint name="turn" type="continuous"><parent link="tool"/><child link="disc"/><axis xyz="0 0 1"/></joint>
  <link name="disc">{inertial(0.1, (1.2e-4, 1.2e-4, 2e-4), '<origin xyz="0.02 0 0"/>')}</link>
</robot>
"""


@pytest.fixture
def urdf(tmp_path: Path) -> Path:
    path = tmp_path / "arm.urdf"
    path.write_text(ROBOT)
    return path


def test_all_engines_are_the_same_machine(urdf: Path, tmp_path: Path) -> None:
    certificate = audit(urdf, [], tmp_path / "out", quiet=True)
    assert certificate.passed, "\n".join(certificate.sentences())
    assert set(engines.available()) <= {row.engine for row in certificate.rows}
    assert all(np.isfinite(row.measured) for row in certificate.rows)

    for row in certificate.rows:
        if row.verdict == "declared":
            assert (row.engine, row.property) == ("dart", "block: depth on soft ground") or row.engine == "ode"
    whole = json.loads((tmp_path / "out" / "audit.json").read_text())
    assert whole["passed"] is True
    assert whole["facts"]["links lumped by fixed joints"] == ["upper carries camera"]
    assert whole["facts"]["links that touch the ground (contact spheres)"] == ["base (8)"]
    with (tmp_path / "out" / "audit.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["property"] for row in rows] == [row.property for row in certificate.rows]
    text = certificate.text()
    assert all(row.property in text for row in certificate.rows)


def test_a_machine_that_differs_from_its_urdf_fails(urdf: Path) -> None:
    robot = load_robot(urdf)
    heavier = replace(robot.described.links[1], mass=robot.described.links[1].mass * (1 + 1e-6))
    links = (robot.described.links[0], heavier, *robot.described.links[2:])
    rows = replace(robot, described=replace(robot.described, links=links)).rows()
    assert {row.verdict for row in rows} == {"failed"}
    assert {row.verdict for row in robot.rows()} == {"passed"}


def test_a_robot_on_a_base_without_mass_is_held(tmp_path: Path) -> None:
    path = tmp_path / "held.urdf"
    path.write_text(ROBOT.replace(BASE, ""))
    robot = load_robot(path)
    assert not robot.described.floating
    assert {row.verdict for row in robot.rows()} == {"passed"}


def test_a_scenario_brings_its_armature_and_step(urdf: Path, tmp_path: Path) -> None:
    path = tmp_path / "scenario.yaml"
    path.write_text(
        "name: arm\nrobot: {urdf: arm.urdf, base: fixed}\n"
        "servos: [{joints: '*', kind: pid, kp: 1, armature: 0.01}]\nphysics: {step_rate: 500}\n"
    )
    robot = load_robot(path)
    assert robot.timestep == 0.002
    np.testing.assert_array_equal(robot.model.armature, [0.01, 0.01, 0.01])
    for check in groups(robot)["robot"]:
        row = check.row(engines.load("mujoco"))
        assert row.verdict == "passed", row


def test_the_oracle_is_free_of_the_choice_of_point_to_order_h2() -> None:
    model = tree()
    oracle, state, effort = Oracle(model), random_state(model, 0), np.zeros(len(model.joints))
    point = np.array([0.1, -0.2, 0.3])

    def difference(h: float) -> float:
        a, b = oracle.step(state, h, effort), oracle.step(state, h, effort, point=point)
        return float(np.abs(velocities(model, a) - velocities(model, b)).max())

    assert difference(1e-3) / difference(5e-4) == pytest.approx(4, rel=0.01)


def test_the_oracle_conserves_momentum_and_energy_in_free_flight() -> None:
    model = tree()
    oracle, state, effort = Oracle(model, np.zeros(3)), random_state(model, 0, fastest=0.5), np.zeros(len(model.joints))
    for _ in range(2):
        momenta, energies = [], []
        for _ in range(200):
            mass, _ = oracle.inertia_and_bias(state)
            momenta.append((mass @ velocities(model, state))[:3])
            energies.append(0.5 * velocities(model, state) @ mass @ velocities(model, state))
            state = oracle.step(state, 1e-4, effort)
        np.testing.assert_allclose(momenta[-1], momenta[0], atol=2e-3)
        assert energies[-1] == pytest.approx(energies[0], rel=1e-2)


def test_all_joints_slide_through_the_step_that_is_audited() -> None:
    """The closed form of the step with friction holds while no joint turns round."""
    for model in (tree(), tree(False)):
        oracle, n = Oracle(model), len(model.joints)
        for seed in range(3):
            state = random_state(model, seed, slowest=0.5)
            mass = oracle.inertia_and_bias(state)[0]
            felt = 1 / np.diag(np.linalg.inv(mass))[len(mass) - n :]
            after = oracle.step(state, 1e-3, 20 * felt, 5 * felt, 10 * felt)
            assert (after.velocity * state.velocity > 0).all()


def test_an_engine_can_be_audited_alone() -> None:
    certificate = certify([engines.load("mujoco")])
    assert {row.engine for row in certificate.rows} == {"mujoco"}
    assert certificate.passed


def test_an_unknown_engine_is_one_sentence() -> None:
    with pytest.raises(InputError, match=r"--engine: found gazebo; expected one of dart, drake") as error:
        audit(None, ["gazebo"], quiet=True)
    assert "\n" not in str(error.value)


def test_without_pinocchio_one_sentence_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    with pytest.raises(InputError, match="pip install pin") as error:
        audit(None, [], quiet=True)
    assert "\n" not in str(error.value)


class Blind(type(engines.load("mujoco"))):  # type: ignore[misc]
    """MuJoCo that says it has no rotor inertia, and has none."""

    def __init__(self, level: str) -> None:
        self.level = level

    def capabilities(self) -> dict[str, Capability]:
        return {**super().capabilities(), "armature": Capability(self.level, "has none")}

    def open(self, model: Model, physics: Physics) -> Simulation:
        bare = model.with_armature(np.zeros(len(model.joints)))
        return engines.load("mujoco").open(bare, physics)


@pytest.mark.parametrize(("level", "verdict"), [("no", "declared"), ("native", "failed")])
def test_what_an_engine_declares_does_not_fail_but_is_measured(level: str, verdict: str) -> None:
    check = next(c for c in groups()["joints"] if c.property == "armature: acceleration")
    row = check.row(Blind(level))
    assert row.verdict == verdict
    assert row.measured == pytest.approx(0.0266 / 4.5e-4)


def test_what_is_not_a_number_fails() -> None:
    assert Check("p", lambda _: float("nan"), 1.0).row(engines.load("mujoco")).verdict == "failed"
    assert largest(np.array([np.nan]), np.zeros(1)) == np.inf
    assert largest(np.zeros(2), np.zeros(3)) == np.inf
    assert not Certificate((Proof("p", "e", np.inf, 1.0, "1", "failed"),)).passed


def test_the_machine_that_is_audited_has_what_engines_must_ignore() -> None:
    model = tree()
    assert all(np.isfinite([j.effort, j.velocity, j.lower, j.upper]).all() for j in model.joints)
    assert all(j.damping > 0 and j.friction > 0 for j in model.joints)
    assert "limit" not in write_urdf(model, spheres=False) or model.joints[3].prismatic


@pytest.mark.parametrize("robot", ["sigmaban/robot.urdf", "wolfgang_2019/urdf/wolfgang_joint_revised.urdf"])
def test_real_robots_are_the_same_machine(data_dir: Path, robot: str) -> None:
    loaded = load_robot(data_dir / robot)
    rows = [check.row(engines.load(name)) for name in engines.available() for check in groups(loaded)["robot"]]
    bad = [row for row in [*rows, *loaded.rows()] if row.verdict == "failed"]
    assert not bad


@pytest.mark.parametrize("name", engines.available())
def test_a_body_that_is_alone_spins_as_forward_dynamics_or_that_is_declared_and_halves_with_the_step(name: str) -> None:
    """Euler's equations of three different moments of inertia."""
    link = Link("body", 12.0, np.zeros(3), np.diag([0.4, 0.3, 0.2]))
    body, engine = Model("body", (link,), (), floating=True), engines.load(name)
    rows = {h: {c.property: c.row(engine) for c in checks_of(body, "body", h)} for h in (1e-3, 5e-4)}
    assert {row.verdict for row in rows[1e-3].values()} <= {"passed", "declared"}
    native = engine.capabilities()["lone_body"].level != "no"
    whole, half = (rows[h]["body: one real step"] for h in rows)
    assert (whole.verdict == "passed") == native
    assert native or half.measured == pytest.approx(whole.measured / 2, rel=0.1)
