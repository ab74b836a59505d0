"""JUnit XML: every cell as a test case, for build servers."""

from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree

from harness.budget import over_budget
from harness.matrix.collect import Collected
from harness.results import write_whole


def excess(collected: Collected, budget: Mapping[str, float]) -> dict[str, list[str]]:
    """Sentences on the cells that exceed a budget, by the cell's key."""
    found = {}
    for task, outcome in collected.cells:
        rows = collected.gaps
        for name, value in vars(outcome.cell).items():
            rows = rows[rows[name].isna() if value is None else rows[name] == value]
        lines = over_budget(rows[rows["outcome"] == "ok"], budget)
        if lines:
            found[task.key] = [f"{task.title}: {line}" for line in lines]
    return found


def write_junit(path: Path, name: str, collected: Collected, over: Mapping[str, list[str]]) -> None:
    """Write a test suite: over budget is a failure, crashed, hung or diverged an error, unsupported is skipped."""
    suite = ElementTree.Element("testsuite", name=name, tests=str(len(collected.cells)))
    counts = {"failures": 0, "errors": 0, "skipped": 0}
    for task, outcome in collected.cells:
        case = ElementTree.SubElement(suite, "testcase", classname=task.file.scenario.name, name=task.title)
        if outcome.steps:
            case.set("time", f"{outcome.wall:.3f}")
        if outcome.outcome == "unsupported":
            counts["skipped"] += 1
            ElementTree.SubElement(case, "skipped", message=outcome.note)
        elif outcome.outcome != "ok":
            counts["errors"] += 1
            ElementTree.SubElement(case, "error", type=outcome.outcome, message=outcome.note)
        elif task.key in over:
            counts["failures"] += 1
            ElementTree.SubElement(case, "failure", message="over budget").text = "\n".join(over[task.key])
    for kind, count in counts.items():
        suite.set(kind, str(count))
    ElementTree.indent(suite)
    write_whole(path, ElementTree.tostring(suite, encoding="utf-8", xml_declaration=True) + b"\n")
