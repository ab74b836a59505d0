"""JUnit XML for build servers."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from realitygap.files.whole import write_whole


@dataclass(frozen=True)
class Case:
    """One test case: a cell, how it went, and the sentences on what exceeded its budget.

    `outcome` is as in the result table; `seconds` is None where nothing was simulated.
    """

    suite: str
    name: str
    outcome: str
    note: str = ""
    seconds: float | None = None
    over: Sequence[str] = ()

    @property
    def verdict(self) -> str | None:
        """JUnit's word for what is not a pass: `failure`, `error`, `skipped`; None for a pass."""
        if self.outcome == "unsupported":
            return "skipped"
        if self.outcome != "ok":
            return "error"
        return "failure" if self.over else None


def write_junit(path: Path, name: str, cases: Sequence[Case]) -> None:
    """Write a test suite: over budget is a failure, crashed, hung or diverged an error, unsupported is skipped."""
    counts = Counter(case.verdict for case in cases)
    suite = ElementTree.Element(
        "testsuite",
        name=name,
        tests=str(len(cases)),
        failures=str(counts["failure"]),
        errors=str(counts["error"]),
        skipped=str(counts["skipped"]),
    )
    for case in cases:
        element = ElementTree.SubElement(suite, "testcase", classname=case.suite, name=case.name)
        if case.seconds is not None:
            element.set("time", f"{case.seconds:.3f}")
        if case.verdict == "failure":
            ElementTree.SubElement(element, "failure", message="over budget").text = "\n".join(case.over)
        elif case.verdict is not None:
            ElementTree.SubElement(element, case.verdict, type=case.outcome, message=case.note)
    ElementTree.indent(suite)
    write_whole(path, ElementTree.tostring(suite, encoding="utf-8", xml_declaration=True) + b"\n")
