"""Multisines that are varied: what is better is kept, inside the limits, and nothing else."""

from dataclasses import replace

import numpy as np
import pytest
from one_joint import pendulum
from realitygap.diagnose.propose.condition import Condition
from realitygap.diagnose.propose.evolve import Part, evolved
from realitygap.diagnose.propose.excitation import Excitation
from realitygap.diagnose.propose.limits import Limits
from realitygap.diagnose.propose.segments import Builder
from realitygap.robot.drive import Array
from realitygap.scenario.schema import Scenario

LIMITS = Limits(*(np.array([x]) for x in (-0.8, 1.2, 4.0, np.inf)))
FREQUENCY = 2.3
"""What the machine of these tests answers to [Hz]."""


def heard(motion: Excitation) -> Array:
    """How much of a motion is at one frequency. Shape (1, 1)."""
    wave = motion.path[:, 0] - motion.path[:, 0].mean()
    return np.array([[abs(wave @ np.exp(2j * np.pi * FREQUENCY * motion.time)) ** 2]])


@pytest.mark.parametrize("seed", range(3))
def test_varied_multisines_show_more_and_stay_within_the_limits(seed: int) -> None:
    builder = Builder(np.ones(1), np.array([0.1]), LIMITS, 0.01)
    scenario = Scenario.model_construct(name="", robot=None)
    condition = Condition("", {}, scenario, pendulum())
    drawn = [Excitation(f"{k}", (s,), condition, 0.01) for k, s in enumerate(builder.every(["multisine", "step"]))]
    refused = list[Excitation]()

    def told(motions: list[Excitation]) -> list[Part]:
        refused.append(motions[0])  # as if it left a limit
        return [(m, heard(m)) for m in motions[1:]]

    first = [(m, heard(m)) for m in drawn]
    better = evolved(first, lambda gram: np.asarray(gram[..., 0, 0]), told, np.random.default_rng(seed))
    waves = [float(g[0, 0]) for m, g in first if m.segments[0].wave is not None]
    assert better
    assert max(float(g[0, 0]) for _, g in better) > max(waves)
    assert min(float(g[0, 0]) for _, g in better) > sorted(waves)[-2]
    assert not {id(m) for m, _ in better} & {id(m) for m in (*drawn, *refused)}
    for motion, _ in better:
        way = motion.path[:, 0]
        assert way[0] == way[-1] == pytest.approx(0.1)
        assert way.min() >= -0.8
        assert way.max() <= 1.2
        assert np.abs(np.diff(way)).max() / 0.01 <= 4.0
    none = [(replace(m), g) for m, g in first if m.segments[0].kind == "step"]
    assert evolved(none, lambda gram: np.asarray(gram[..., 0, 0]), told, np.random.default_rng(0)) == []
