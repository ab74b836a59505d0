"""Which keys of a scenario's recordings are for which kind of recording: one that none of them takes is a mistake."""

from collections.abc import Iterator, Sequence

from realitygap.files.errors import InputError, standing
from realitygap.recording import reader_of
from realitygap.scenario.file import RunCase, ScenarioFile
from realitygap.scenario.section import Section

BAG, TABLE, DATASET = "rosbag", "table", "lerobot"
KINDS = {
    BAG: ("bags", "a bag", "its topics in recordings.state and motion.recorded, its units in recordings.columns.units"),
    TABLE: (
        "tables (CSV, Parquet)",
        "a table",
        "its columns in recordings.columns and motion.recorded, their units in recordings.columns.units",
    ),
    DATASET: (
        "LeRobot data sets",
        "a data set",
        "its features in recordings.columns and motion.recorded, their units in recordings.dataset.units",
    ),
}
"""By reader: what recordings of a kind are called, one of them, and where a scenario says what it holds."""
TAKEN_BY = {
    "state": (BAG,),
    "pose": (BAG,),
    "imu": (BAG,),
    "temperature": (BAG,),
    "columns": (TABLE, DATASET),
    "columns.units": (TABLE, BAG),
    "columns.units.time": (TABLE,),
    "dataset": (DATASET,),
}
"""The readers that take a key under `recordings`, and those below it. All of them take the others."""
LEFT_IN_PLACE = ("state",)
"""Keys that are told and not refused where no recording takes them: they stay when a bag is exported to a table."""


def fitting_cases(file: ScenarioFile) -> list[RunCase]:
    """The recordings of a scenario, as `ScenarioFile.cases`, every one of whose keys some of them take.

    Raises:
        InputError: as that does; for a key that is of another kind of recording than all of those it is stated for.
    """
    cases = file.cases()
    for key, known, found in _untaken(file, cases):
        if known not in LEFT_IN_PLACE:
            raise InputError(f"{file.path}: recordings.{key}: is for {_takers(known)}; {found}")
    return cases


def unused_keys(file: ScenarioFile, cases: Sequence[RunCase]) -> list[str]:
    """Sentences on the keys of a scenario's recordings that are left in place, and that none of them takes."""
    left = {known: found for _, known, found in _untaken(file, cases) if known in LEFT_IN_PLACE}
    return [f"recordings.{known}: is for {_takers(known)}, and not used; {found}" for known, found in left.items()]


def _untaken(file: ScenarioFile, cases: Sequence[RunCase]) -> Iterator[tuple[str, str, str]]:
    """Every key that none of the recordings takes which it is stated for, the part of it that `TAKEN_BY` knows, and
    words on what was found.

    Raises:
        InputError: for a recording that nothing here reads.
    """
    stated: dict[str, list[tuple[RunCase, str]]] = {}
    for case in cases:
        with standing(f"{file.path}: {case.key}.path: "):
            reader = reader_of(case.path)
        for key in _stated(case.scenario.recordings):
            stated.setdefault(key, []).append((case, reader))
    for key, of in stated.items():
        known = _known(key)
        if known is not None and all(reader not in TAKEN_BY[known] for _, reader in of):
            case, reader = of[0]
            _, one, instead = KINDS[reader]
            yield key, known, f"found {one}, {case.path}; expected {instead}"


def _known(key: str) -> str | None:
    """The longest part of a key of which it is known who takes it; None where all do."""
    parts = key.split(".")
    known = (".".join(parts[:count]) for count in range(len(parts), 0, -1))
    return next((part for part in known if part in TAKEN_BY), None)


def _takers(known: str) -> str:
    return " and ".join(KINDS[taker][0] for taker in TAKEN_BY[known])


def _stated(section: Section | None, prefix: str = "") -> Iterator[str]:
    """The keys that a scenario states, in the order of the reference; those of a section in it with dots."""
    if section is None:
        return
    for name in type(section).model_fields:
        value = getattr(section, name)
        if name in section.model_fields_set and isinstance(value, Section):
            yield from _stated(value, f"{prefix}{name}.")
        elif name in section.model_fields_set:
            yield f"{prefix}{name}"
