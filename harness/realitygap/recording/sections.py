"""Which keys of a scenario's recordings are for which kind of recording: one that none of them takes is a mistake."""

from collections.abc import Iterator

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
    "pose": (BAG,),
    "imu": (BAG,),
    "temperature": (BAG,),
    "columns": (TABLE, DATASET),
    "columns.units": (TABLE, BAG),
    "columns.units.time": (TABLE,),
    "dataset": (DATASET,),
}
"""The readers that take a key under `recordings`, and those below it. All of them take the others: a topic of the state
that is left in place beside a table says nothing that the table does not."""


def fitting_cases(file: ScenarioFile) -> list[RunCase]:
    """The recordings of a scenario, as `ScenarioFile.cases`, every one of whose keys some of them take.

    Raises:
        InputError: as that does; for a key that is of another kind of recording than all of those it is stated for.
    """
    cases = file.cases()
    stated: dict[str, list[tuple[RunCase, str]]] = {}
    for case in cases:
        with standing(f"{file.path}: {case.key}.path: "):
            reader = reader_of(case.path)
        for key in _stated(case.scenario.recordings):
            stated.setdefault(key, []).append((case, reader))
    for key, of in stated.items():
        takers = _takers(key)
        if all(reader not in takers for _, reader in of):
            case, reader = of[0]
            _, found, instead = KINDS[reader]
            raise InputError(
                f"{file.path}: recordings.{key}: is for {' and '.join(KINDS[t][0] for t in takers)}; found {found}, "
                f"{case.path}; expected {instead}"
            )
    return cases


def _takers(key: str) -> tuple[str, ...]:
    """The readers that take a key, as the longest part of it says that is known."""
    parts = key.split(".")
    known = (".".join(parts[:count]) for count in range(len(parts), 0, -1))
    return next((TAKEN_BY[part] for part in known if part in TAKEN_BY), tuple(KINDS))


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
