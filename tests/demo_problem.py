"""The bundled demo (synthetic) as a diagnosis sees it, and one of its suspects."""

from pathlib import Path

from realitygap.diagnose.candidates.suspects import suspects
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.problem import Problem, build_problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.likelihood.floors import measure
from realitygap.diagnose.rehearse.planting import plant_recordings
from realitygap.scenario.file import load_scenario

DEMO = Path(__file__).parents[1] / "scenarios" / "demo" / "scenario.yaml"
FRICTION = 0.6447
"""Coulomb friction of the recorded elbow [N·m]."""


def demo_problem() -> Problem:
    return build_problem(load_scenario(DEMO), "mujoco")


def planted(*missing: Change) -> Problem:
    """The demo's motions, recorded with what is missing."""
    bare = demo_problem()
    with Simulations(bare, 2) as simulations:
        floors = measure(simulations, [])
    return plant_recordings(bare, floors, missing, "mujoco")


def suspect_of(problem: Problem, effect: str, target: str) -> Suspect:
    return next(s for s in suspects(problem) if s.effect == effect and s.target == target)
