"""All checks of one scenario, and what the other commands ask of them."""

from collections.abc import Iterable, Sequence
from fnmatch import fnmatchcase
from shlex import quote

from realitygap.check.driven import drives_nothing, servo_patterns
from realitygap.check.few import few_samples
from realitygap.check.limits import limit_mistakes
from realitygap.check.links import link_mistakes
from realitygap.check.load import load_mistakes
from realitygap.check.mistake import KINDS, Mistake, merged
from realitygap.check.observed import Observed, Read, observe
from realitygap.check.recordings import joints_of, recording_mistakes
from realitygap.check.repetitions import repetition_mistakes
from realitygap.check.welded import welded_mistakes
from realitygap.check.window import window_mistakes
from realitygap.files.errors import InputError, did_you_mean
from realitygap.recording import read_recording
from realitygap.robot.plant import Plant, build_plant, whole_model
from realitygap.robot.suspicion import check_suspicion
from realitygap.scenario.file import ScenarioFile


def check(file: ScenarioFile, read: Read = read_recording) -> list[Mistake]:
    """Every mistake in a scenario, its robot and its recordings, certain ones first, also those that it accepts.

    No physics is simulated and none is blamed: what a servo, a load or friction can do is no mistake.

    Raises:
        InputError: for what cannot be read at all, or a key of the scenario that names what does not exist.
    """
    observed = observe(file, read)
    plants = list({id(o.plant): o.plant for o in observed}.values()) or [build_plant(file)]
    _check_accepted(file, plants, observed)
    check_suspicion(file, plants[0].model)
    found = servo_patterns(file, plants)
    whole = drives_nothing(file, plants, observed)
    found += [m for plant in plants for m in (*limit_mistakes(plant), *link_mistakes(plant))]
    found += recording_mistakes(observed, driven=not whole)
    welded = welded_mistakes(file, observed, read)
    if not found and not whole:
        found += load_mistakes(observed)
    if not whole and not any(m.certainty == "certain" for m in found):
        found += repetition_mistakes(observed, joints_of(found))
    return merged([*whole, *found, *welded, *(m for o in observed for m in (*few_samples(o), *window_mistakes(o)))])


def certain(file: ScenarioFile, read: Read = read_recording) -> list[Mistake]:
    """The likely mistakes in a scenario, as warnings; those that it accepts are left out.

    Raises:
        InputError: for a certain mistake, in one sentence; and as `check`.
    """
    found = [m for m in check(file, read) if not accepted(file, m)]
    sure = [m for m in found if m.certainty == "certain"]
    if sure:
        more = "" if len(sure) == 1 else f" ({len(sure) - 1} more: `realitygap check {quote(str(file.path))}`)"
        raise InputError(f"{file.path}: {sure[0].text}{more}")
    return found


def accepted(file: ScenarioFile, mistake: Mistake) -> bool:
    """Whether the scenario's `accept` says that this is none: its kind, at all of its joints."""
    where = [w or "*" for k, _, w in (entry.partition("@") for entry in file.scenario.accept) if k == mistake.kind]
    names = mistake.joints or ("",)
    return bool(where) and all(any(fnmatchcase(name, w) for w in where) for name in names)


def blamed_joints(warnings: Iterable[Mistake]) -> set[str]:
    """The joints at which a mistake is likely, so that no physics is named there."""
    return joints_of(warnings)


def _check_accepted(file: ScenarioFile, plants: Sequence[Plant], observed: Sequence[Observed]) -> None:
    names = _joint_names(file, plants, observed) if file.scenario.accept else []
    for i, entry in enumerate(file.scenario.accept):
        kind, _, where = entry.partition("@")
        if kind not in KINDS:
            known = ", ".join(KINDS)
            raise InputError(
                f"{file.path}: accept[{i}]: found {entry}; expected one of {known}{did_you_mean(kind, KINDS)}"
            )
        if where and not any(fnmatchcase(name, where) for name in names):
            raise InputError(
                f"{file.path}: accept[{i}]: {where} matches no joint; the robot has {', '.join(dict.fromkeys(names))}"
            )


def _joint_names(file: ScenarioFile, plants: Sequence[Plant], observed: Sequence[Observed]) -> list[str]:
    """The joints of every run's robot, those that it holds among them."""
    scenarios = [o.scenario for o in observed] or [file.scenario]
    holding = {s.robot.model_dump_json(): s for s in scenarios if s.robot.hold}
    models = [*(plant.model for plant in plants), *(whole_model(file, s) for s in holding.values())]
    return [name for model in models for name in model.joint_names]
