"""JUnit XML for build servers: every cell is a test case."""

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.etree import ElementTree

from realitygap.files.whole import write_whole
from realitygap.matrix.task import Outcome, Task


def write_junit(
    path: Path, name: str, cells: Sequence[tuple[Task, Outcome]], over: Mapping[str, Sequence[str]]
) -> None:
    """Write a test suite: over budget is a failure, crashed, hung or diverged an error, unsupported is skipped.

    Args:
        path: the file.
        name: of the suite.
        cells: every cell and what became of it.
        over: sentences on what exceeded its budget, by the cell's key.
    """
    verdicts = [_verdict(outcome.outcome, bool(over.get(task.key))) for task, outcome in cells]
    counts = Counter(verdicts)
    suite = ElementTree.Element(
        "testsuite",
        name=name,
        tests=str(len(cells)),
        failures=str(counts["failure"]),
        errors=str(counts["error"]),
        skipped=str(counts["skipped"]),
    )
    for (task, outcome), verdict in zip(cells, verdicts, strict=True):
        case = ElementTree.SubElement(suite, "testcase", classname=task.file.scenario.name, name=task.title)
        if outcome.steps:
            case.set("time", f"{outcome.wall:.3f}")
        if verdict == "failure":
            ElementTree.SubElement(case, verdict, message="over budget").text = "\n".join(over[task.key])
        elif verdict is not None:
            ElementTree.SubElement(case, verdict, type=outcome.outcome, message=outcome.note)
    ElementTree.indent(suite)
    write_whole(path, ElementTree.tostring(suite, encoding="utf-8", xml_declaration=True) + b"\n")


def _verdict(outcome: str, over: bool) -> str | None:
    """JUnit's word for what is not a pass; None for a pass."""
    if outcome == "unsupported":
        return "skipped"
    if outcome != "ok":
        return "error"
    return "failure" if over else None
