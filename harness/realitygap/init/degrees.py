"""Angles in degrees in a table or bag: what the check of a draft says of them, and units under which it is silent."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

from realitygap_engines.model.robot import Model

from realitygap.check import Mistake, check
from realitygap.files.errors import InputError
from realitygap.init.sections import Sections, Units
from realitygap.recording import Recording
from realitygap.scenario.file import ScenarioFile


def in_degrees(
    file: ScenarioFile, sections: Sections, model: Model, recordings: Mapping[Path, Recording]
) -> Sections | None:
    """The sections with `deg` where the check of the draft is certain of it; None where it is not.

    What a position is in, other columns and joints mostly are in, too: of the units that agree with what was found,
    the first that leave no angle to complain of are taken.

    Args:
        file: the draft.
        sections: of the draft.
        model: the robot.
        recordings: as the draft reads them, by path.
    """
    if not sections.angles:
        return None

    by_path = {path.resolve(): recording for path, recording in recordings.items()}

    def known(path: Path, *_: Any, **__: Any) -> Recording:
        return by_path[path.resolve()]

    try:
        found = _turned(check(file, known))
        sure = [m for m in found if m.certainty == "certain"]
        for units in _possible(sure, sections.angles, model) if sure else ():
            stated = sections.units | units
            if not _turned(check(file.override({"recordings.columns.units": stated}))):
                return replace(sections, units=stated, units_by=f"GUESS: in rad, {sure[0].found}")
    except InputError:  # of a mesh that is not there, say, which a first draft does without
        return None
    return None


def _turned(mistakes: list[Mistake]) -> list[Mistake]:
    return [m for m in mistakes if m.kind == "degrees" and m.signal]


def _possible(sure: list[Mistake], angles: tuple[str, ...], model: Model) -> Iterator[Units]:
    """Units that agree with the mistakes: their signals are in degrees, and others may be.

    Where the position is, the others are compared with what it was: most of them in degrees come first. A position of
    which nothing is said stays as it is.
    """
    named = [s for s in angles if s in {m.signal for m in sure}]
    others = [s for s in angles if s not in named and s != "position"]
    most_first = -1 if "position" in named else 1
    joints = [j.name for j in model.joints if not j.prismatic]
    where = dict.fromkeys((tuple(joints), tuple(j for j in joints if any(j in m.joints for m in sure))))
    for turning in where:
        rest = {j.name: "m" if j.prismatic else "rad" for j in model.joints if j.name not in turning}
        unit: str | dict[str, str] = {**rest, "*": "deg"} if rest else "deg"
        for count in range(len(others) + 1)[::most_first]:
            for more in combinations(others, count):
                yield {signal: unit for signal in angles if signal in (*named, *more)}
