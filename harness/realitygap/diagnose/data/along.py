"""The fitted motions as they were measured: what effort they take, without the servos that drove them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from realitygap.diagnose.data.case import Case
from realitygap.diagnose.data.problem import Problem
from realitygap.files.errors import InputError
from realitygap.robot.drive import Array
from realitygap.robot.effects import EFFECTS
from realitygap.robot.effects.place import known, place
from realitygap.robot.plant import Plant, build_plant, match_joints
from realitygap.scenario.file import ScenarioFile
from realitygap.scenario.schema import EffectSpec, Motion, Scenario
from realitygap.simulate.follow import Followed, check_clear, check_maps
from realitygap.simulate.inputs import supply_of

OF_SERVOS = (
    ("rotor_inertia", "armature", "armature"),
    ("coulomb_friction", "torque", "coulomb"),
    ("viscous_friction", "coefficient", "viscous"),
)
"""What a servo says of its joint: the effect that says the same, its parameter, and the field of the drive."""


def along_the_motion(problem: Problem) -> Problem | None:
    """The fitted motions of driven joints as ones that are followed (`simulate.follow`), of which the measured effort
    tells what the joints lack without simulating anything over time; None where no effort was measured, where the base
    is not fixed, or where such a scenario cannot be stated.
    """
    scenario, train = problem.file.scenario, [problem.cases[i] for i in problem.of("train")]
    measured = [case for case in train if "effort" in case.noise and np.isfinite(case.value("position")).all()]
    if scenario.follows or scenario.effort_measures == "none" or scenario.robot.base != "fixed" or not measured:
        return None
    try:
        ways: dict[str, tuple[Scenario, Plant]] = {}
        for one in (scenario, *(case.experiment.scenario for case in measured)):
            if _robot(one) not in ways:  # most runs share it
                ways[_robot(one)] = _without_servos(problem.file, one)
        cases = tuple(_followed(case, *ways[_robot(case.experiment.scenario)]) for case in measured)
    except InputError:  # as where a link comes to the ground
        return None
    followed, plant = ways[_robot(scenario)]
    driven = problem.plant
    plant.reached, plant.travelled, plant.exerted = driven.reached, driven.travelled, driven.exerted
    plant.lagged = driven.lagged
    file = ScenarioFile(problem.file.path, followed, problem.file.raw)
    return replace(problem, file=file, plant=plant, cases=cases, split="", notes=())


def _robot(scenario: Scenario) -> str:
    """What runs share that differ in what was recorded of them alone."""
    return scenario.model_dump_json(exclude={"recordings"})


def _without_servos(file: ScenarioFile, scenario: Scenario) -> tuple[Scenario, Plant]:
    """A scenario with motions that are followed, and its plant: what servos say of their joints is said by effects."""
    shown = [spec for spec in scenario.effects if not known(spec.effect).unseen_when_followed]
    robot = scenario.robot.model_copy(update={"start": "recording"})
    without = {"servos": [], "certain": [], "suspects": [], "motion": Motion(followed=True), "robot": robot}
    followed = scenario.model_copy(update=without)
    bare, driven = build_plant(file, followed), build_plant(file, scenario)
    bare.drive["current_factor"] = 0.0  # in a simulation an effort is told as an effort, not as a current
    said = _said_by_servos(driven, bare, shown)
    followed = followed.model_copy(update={"effects": [*said, *shown]})
    return followed, place(bare, followed.effects)


def _said_by_servos(driven: Plant, bare: Plant, stated: list[EffectSpec]) -> list[EffectSpec]:
    """Rotor and friction of each joint that its servo says, and neither the robot's file nor an effect does."""
    out = []
    for effect, parameter, value in OF_SERVOS:
        same = (effect, *EFFECTS[effect].excludes)
        told = {j for s in stated if s.effect in same for j in match_joints(driven.model, s.target)}
        for j, name in enumerate(driven.model.joint_names):
            if j not in told and driven.drive[value][j] != bare.drive[value][j]:
                out.append(EffectSpec(effect=effect, target=name, **{parameter: float(driven.drive[value][j])}))
    return out


def _followed(case: Case, scenario: Scenario, plant: Plant) -> Case:
    """A motion that is followed, of which the effort is judged."""
    e = case.experiment
    assert e.recording is not None
    position = case.value("position")
    plant, _ = plant.passing(position)
    followed = Followed(case.measured.time, position, supply_of(e.recording, 0.0))
    experiment = replace(e, scenario=scenario, plant=plant, followed=followed, midway=None, notes=())
    check_clear(plant, followed, experiment.start())
    check_maps(plant, supply=followed.supply is not None)
    return replace(
        case,
        experiment=experiment,
        noise=_of_effort(case.noise),
        white=_of_effort(case.white),
        spread=_of_effort(case.spread),
        windows=(),
        length=np.inf,
    )


def _of_effort(noise: dict[str, Array]) -> dict[str, Array]:
    """Of the noise of every signal that of the effort: a motion that is followed is no answer."""
    return {signal: deviation for signal, deviation in noise.items() if signal == "effort"}
