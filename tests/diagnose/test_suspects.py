"""What a search looks at first, by how many joints a robot has."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from realitygap.diagnose.candidates.suspects import FEW, OWN, everyday, plain_first, suspects
from realitygap.diagnose.data.problem import Problem, build_problem
from realitygap.diagnose.result.story_text import places
from realitygap.scenario.file import load_scenario

LINK = (
    '<link name="{}"><inertial><mass value="0.1"/>'
    '<inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>'
)
JOINT = (
    '<joint name="{}" type="revolute"><parent link="{}"/><child link="{}"/><axis xyz="0 1 0"/>'
    '<limit lower="-3" upper="3" effort="9" velocity="9"/></joint>'
)


def chain(folder: Path, joints: int) -> Problem:
    """A chain with two types of servo and two recordings that are sines."""
    links = [f"link{i}" for i in range(joints + 1)]
    names = [f"joint{i}" for i in range(joints)]
    inner = [JOINT.format(n, *pair) for n, pair in zip(names, pairwise(links), strict=True)]
    urdf = f'<robot name="chain">{"".join(LINK.format(n) for n in links)}{"".join(inner)}</robot>'
    (folder / "robot.urdf").write_text(urdf, encoding="utf-8")
    time = np.arange(0.0, 1.0, 0.01)
    for run in ("a", "b"):
        told = {f"{kind}.{n}": np.sin(5.0 * time + i) for i, n in enumerate(names) for kind in ("command", "position")}
        pd.DataFrame({"time": time, **told}).to_csv(folder / f"{run}.csv", index=False)
    drive = {"kind": "dc", "gain": 5.0, "duty_limit": 1.0, "supply": 12.0, "torque_constant": 1.5, "resistance": 3.0}
    scenario = {
        "name": "chain",
        "robot": {"urdf": "robot.urdf", "base": "fixed"},
        "servos": [
            {"name": "strong", "joints": names[: joints // 2], "armature": 0.02, **drive},
            {"name": "weak", "joints": "*", "armature": 0.01, **drive},
        ],
        "motion": {"recorded": "command"},
        "physics": {"step_rate": 500},
        "recordings": {"runs": [{"path": "a.csv", "use": "train"}, {"path": "b.csv", "use": "held_out"}]},
    }
    (folder / "scenario.yaml").write_text(yaml.safe_dump(scenario), encoding="utf-8")
    return build_problem(load_scenario(folder / "scenario.yaml"), "mujoco")


@pytest.mark.parametrize("joints", [FEW, FEW + 2])
def test_with_many_joints_a_plain_fit_comes_first_and_has_one_value_for_every_type_of_servo(
    joints: int, tmp_path: Path
) -> None:
    problem = chain(tmp_path, joints)
    everyone = suspects(problem)
    plain = [s for s in everyone if everyday(problem, s)]
    friction = {s.indices for s in plain if s.effect == "coulomb_friction"}
    half, every = joints // 2, range(joints)
    if joints > FEW:
        assert friction == {tuple(every[:half]), tuple(every[half:]), tuple(every)}
        assert plain_first(problem, everyone) == plain
    else:
        assert friction == {(i,) for i in every}
        assert plain_first(problem, everyone) == everyone
    assert all(len(s.indices) == 1 for s in plain if s.effect in OWN)


def test_the_joints_of_several_types_of_servo_are_counted_and_not_the_types(tmp_path: Path) -> None:
    everyone = suspects(chain(tmp_path, 5))
    types = [s for s in everyone if s.effect == "coulomb_friction" and s.servo]
    assert places(types) == "5 joints"
    assert places([s for s in everyone if s.effect == "coulomb_friction" and len(s.indices) == 1]) == "5 joints"
