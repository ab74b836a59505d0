"""No proposed motion leaves a limit: as it is written, under every rival, in every engine, in random scenarios.

`python tests/bench_propose.py --safe 1000` tries many.
"""

import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
import realitygap_engines as engines
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from realitygap.diagnose.propose.condition import Condition
from realitygap.diagnose.propose.excitation import Excitation, experiment_of
from realitygap.diagnose.propose.keyframes import played
from realitygap.diagnose.propose.limits import Limits
from realitygap.diagnose.propose.safe import later, left_limits, phases
from realitygap.diagnose.propose.segments import Builder
from realitygap.robot.effects.place import place
from realitygap.scenario.file import load_scenario
from realitygap.scenario.schema import EffectSpec
from realitygap.simulate.experiment import Experiment, experiments, simulate
from realitygap.simulate.motion import TICK

URDF = """<robot name="pendulum"><link name="base"/>
<link name="arm"><inertial><origin xyz="0 0 -0.15"/><mass value="1.2"/>
<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.001"/></inertial></link>
<joint name="elbow" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="12" velocity="8"/></joint></robot>"""
WIDE = Limits(*(np.array([x]) for x in (-3.0, 3.0, 50.0, 50.0)))
EVERY = engines.available()


@pytest.fixture(scope="module")
def planted() -> Iterator[None]:
    """The robots of the blind suite import one another by name."""
    folder = str(Path(__file__).parents[1] / "planted")
    sys.path.insert(0, folder)
    yield
    sys.path.remove(folder)


@pytest.mark.parametrize("standing", [False, True], ids=["fixed", "standing"])
@settings(max_examples=3, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**31), other=st.integers(0, len(EVERY) - 1))
@pytest.mark.usefixtures("planted")
def test_no_motion_leaves_a_limit_under_any_rival(standing: bool, seed: int, other: int) -> None:
    from random_proposals import left

    with TemporaryDirectory() as folder:
        _, outside = left(seed, Path(folder), list(dict.fromkeys(["mujoco", EVERY[other]])), standing)
    assert outside == []


@pytest.fixture
def designed(tmp_path: Path) -> tuple[Excitation, Experiment]:
    """A chirp of a pendulum."""
    (tmp_path / "pendulum.urdf").write_text(URDF, encoding="utf-8")
    (tmp_path / "any.json").write_text('{"keyframes": [{"goals": {}, "duration": 1.0}]}', encoding="utf-8")
    servo = {"joints": "*", "kind": "pid", "kp": 12.0, "kd": 0.6}
    content = {
        "name": "chirp",
        "robot": {"urdf": "pendulum.urdf", "base": "fixed", "start": "keyframe"},
        "servos": [{**servo, "armature": 0.01, "friction": {"coulomb": 0.1, "viscous": 0.05}}],
        "motion": {"keyframes": "any.json"},
    }
    (tmp_path / "any.yaml").write_text(yaml.safe_dump(content), encoding="utf-8")
    (any_,) = experiments(load_scenario(tmp_path / "any.yaml"))
    segments = Builder(
        np.ones(1), np.array([0.1]), Limits(*(np.array([x]) for x in (-1.0, 1.2, 5.0, 12.0))), 0.01
    ).every(["chirp"])
    motion = Excitation("chirp", tuple(segments[:1]), Condition("", {}, any_.scenario, any_.plant), 0.01)
    return motion, experiment_of(motion)


@pytest.mark.parametrize("rate", [11.0, 14.0, 23.0])
def test_limits_hold_as_a_motion_is_designed_and_as_it_is_played(
    designed: tuple[Excitation, Experiment], rate: float
) -> None:
    """A servo that samples slowly samples other commands where a motion begins later: any may be the fastest."""
    motion, one = designed
    plant = place(one.plant, [EffectSpec(effect="servo_rate", target="elbow", rate=rate)])
    ways = [later(way, k / 4 / rate).with_plant(plant) for way in (one, played(motion, one)) for k in range(4)]
    traces = [simulate(way, "mujoco").trace.between(-TICK, np.inf) for way in ways]
    fastest = [float(np.abs(t.velocity).max()) for t in traces if t.velocity is not None]
    assert fastest[0] != pytest.approx(fastest[1], rel=1e-4)
    assert fastest[0] != pytest.approx(fastest[4], rel=1e-4)
    for share, held in ((1.001, ("mujoco",)), (0.999, ())):
        limits = Limits(WIDE.lower, WIDE.upper, np.array([share * max(fastest)]), WIDE.effort)
        assert left_limits(one, motion, [plant], ["mujoco"], limits)[1] == held


def test_when_a_motion_begins_is_nothing_to_a_servo_without_samples(designed: tuple[Excitation, Experiment]) -> None:
    _, one = designed
    assert phases(one.plant) == [0.0]
    now, then = (simulate(later(one, late), "mujoco").trace.between(0.0, 2.0) for late in (0.0, 0.03))
    assert now.velocity is not None
    assert then.at(now.time).velocity == pytest.approx(now.velocity, abs=2e-3)


@pytest.mark.parametrize("offset", [-0.2, 0.15])
def test_a_servo_holds_its_reading_where_keyframes_start(
    designed: tuple[Excitation, Experiment], offset: float
) -> None:
    motion, one = designed
    plant = place(one.plant, [EffectSpec(effect="joint_offset", target="elbow", angle=offset)])
    trace = simulate(played(motion, one).with_plant(plant), "mujoco").trace
    assert trace.position is not None
    assert trace.effort is not None
    assert trace.position[0] == pytest.approx(motion.path[0], abs=1e-6)
    assert np.abs(trace.effort[0]).max() < 0.1
