"""The cases: what is planted, what is written, and which ones there are."""

import filecmp
import os
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from realitygap.scenario.file import load_scenario

sys.path.insert(0, str(Path(__file__).parent))  # plain modules, not a package

import cases
import planted
import robots
from catalogue import COUNTS, catalogue
from chain import GRAVITY


@pytest.mark.parametrize("effect", planted.EVERY)
def test_every_effect_is_planted_as_it_is_told(effect: str) -> None:
    kind = "skew"
    robot = robots.BUILDERS[kind](np.random.default_rng(2))
    robot.torque = robot.speed = robot.peak = robot.fastest = np.ones(2)
    plant = robot.plant()
    told = planted.plant(effect, plant, robot, 1, 1.0, np.random.default_rng(3))
    assert told.effect in planted.TABLE
    assert all(np.isfinite(v) for v in told.parameters.values())
    model = robot.plant()
    changed = (
        any(not np.array_equal(plant.drive[n], model.drive[n]) for n in plant.drive.dtype.names or ())
        or plant.sag > 0
        or any(not np.array_equal(a, b) for a, b in zip(plant.chain.arrays(), model.chain.arrays(), strict=True))
        or plant.velocity_time.any()
    )
    assert changed


@pytest.mark.parametrize(("kind", "robot"), [("single", "pendulum"), ("nothing", "skew"), ("nearly_several", "planar")])
def test_a_case_is_written_alike_twice_and_reads_as_a_scenario(kind: str, robot: str, tmp_path: Path) -> None:
    case = next(c for c in catalogue(kind) if c.robot == robot)
    truths = [cases.generate(case, tmp_path / name) for name in ("a", "b")]
    assert truths[0] == truths[1]
    folder = tmp_path / "a" / "cases" / case.name
    for path in sorted(p for p in folder.rglob("*") if p.is_file()):
        assert filecmp.cmp(path, tmp_path / "b" / path.relative_to(tmp_path / "a"), shallow=False), path.name
        assert not any(t["effect"].encode() in path.read_bytes() for t in truths[0]["truth"]), path.name
    runs = load_scenario(folder / "scenario.yaml").cases()
    assert {r.run.use for r in runs} == {"train", "held_out"}
    assert all(t["visibility"] > 1.0 for t in truths[0]["truth"])


def test_the_catalogue_is_as_large_as_promised() -> None:
    assert {k: len(catalogue(k)) for k in COUNTS} == COUNTS
    singles = catalogue("single")
    assert len({c.name for c in singles}) == len(singles) >= 60
    assert {c.effects[0][0] for c in singles} == set(planted.EVERY)
    assert all(
        planted.fits(e, robots.BUILDERS[c.robot](np.random.default_rng(0))) for c in singles for e, _ in c.effects
    )
    half = catalogue("half")
    assert {(c.sensing.rate, c.sensing.effort) for c in half} == {(100.0, False)}


@pytest.mark.skipif("REALITYGAP_DATA" not in os.environ, reason="REALITYGAP_DATA is not set: no humanoid here")
def test_the_humanoid_stands_and_sinks_into_soft_ground() -> None:
    import humanoid
    import standing

    robot = humanoid._robot()
    command = humanoid.command("squat", robot, 100.0, 0.1, 1)
    heights = []
    for ground in (standing.Ground(), standing.Ground(stiffness=3000.0, damping=100.0)):
        body = replace(humanoid._humanoid(robot), ground=ground)
        robot.peak = np.ones(len(robot.joints))
        robot.bristles(body.plant)
        _, height = standing.simulate(body, command, 0.05)
        heights.append(height[0])
    weight = 7.779 * GRAVITY
    assert heights[0] - heights[1] == pytest.approx(weight / 8 * (1 / 3000 - 1 / standing.RIGID[0]), rel=0.3)
