"""What an audit writes: rows of measured errors, and the certificate made of them."""

import csv
import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from io import StringIO
from pathlib import Path
from typing import Literal

from rich import box
from rich.console import Console
from rich.table import Table

from realitygap.files.interrupted import last
from realitygap.files.spreadsheet import as_words
from realitygap.files.whole import write_whole

Verdict = Literal["passed", "failed", "declared", "information"]
STYLE: dict[Verdict, str] = {"passed": "green", "failed": "bold red", "declared": "yellow", "information": "dim"}


@dataclass(frozen=True)
class Proof:
    """One property of one engine.

    Attributes:
        property: what was checked.
        engine: the engine, or "all" for a comparison between engines.
        measured: the error found, in `unit`; not finite where nothing could be measured.
        tolerance: the largest error that passes; infinite for information.
        unit: of both; "1" for a relative error.
        verdict: passed, failed, declared (the engine says that it cannot express this) or information.
        note: how it was measured, or why it failed.
    """

    property: str
    engine: str
    measured: float
    tolerance: float
    unit: str
    verdict: Verdict
    note: str = ""


@dataclass(frozen=True)
class Certificate:
    """The rows of an audit, the versions it holds for, and facts about the robot that was audited."""

    rows: tuple[Proof, ...]
    versions: Mapping[str, str] = field(default_factory=dict)
    facts: Mapping[str, object] = field(default_factory=dict)

    @property
    def failures(self) -> list[Proof]:
        """The rows that failed."""
        return [row for row in self.rows if row.verdict == "failed"]

    @property
    def passed(self) -> bool:
        """Whether every row passed, was declared or is information."""
        return not self.failures

    def table(self) -> Table:
        """The certificate for a terminal: one line per property, one column per engine, then the tolerance."""
        engines = list(dict.fromkeys(row.engine for row in self.rows))
        title = "Audit: " + ", ".join(f"{name} {version}" for name, version in self.versions.items())
        table = Table(title=title, box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0))
        table.add_column("property", no_wrap=True)
        for engine in engines:
            table.add_column(engine, justify="right", min_width=8)
        table.add_column("tolerance", justify="right")
        by_property: dict[str, dict[str, Proof]] = {}
        for row in self.rows:
            by_property.setdefault(row.property, {})[row.engine] = row
        for name, found in by_property.items():
            cells = [_cell(found[engine]) if engine in found else "" for engine in engines]
            first = next(iter(found.values()))
            limits = sorted({row.tolerance for row in found.values()})
            limit = " / ".join(f"{t:.0e}" for t in limits if math.isfinite(t))
            table.add_row(name, *cells, f"{limit} {first.unit if first.unit != '1' else ''}".strip())
        return table

    def text(self, width: int = 120) -> str:
        """The certificate in words: table, sentences and verdict."""
        console = Console(width=width, file=StringIO(), record=True, highlight=False)
        console.print(self.table())
        count = {verdict: [row.verdict for row in self.rows].count(verdict) for verdict in STYLE}
        verdict = ", ".join(f"{number} {name}" for name, number in count.items() if number)
        return "\n".join([console.export_text().rstrip(), *self.sentences(), verdict])

    def sentences(self) -> list[str]:
        """One sentence for every row that failed or was declared, and one for every fact."""
        out = []
        for row in self.rows:
            if row.verdict in ("failed", "declared"):
                found = f"{row.measured:.3g}" + ("" if row.unit == "1" else f" {row.unit}")
                note = f"; {row.note}" if row.note else ""
                out.append(f"{row.engine}: {row.property}: {row.verdict}: {found}, tolerance {row.tolerance:g}{note}")
        return out + [f"{name}: {_words(value)}" for name, value in self.facts.items()]

    def write(self, folder: Path) -> None:
        """Write audit.json and audit.csv into a folder; numbers that are not finite are null and empty there."""
        rows = [{k: _finite(v) for k, v in asdict(row).items()} for row in self.rows]
        whole = {
            "schema": 1,
            "passed": self.passed,
            "versions": dict(self.versions),
            "facts": dict(self.facts),
            "rows": rows,
        }
        table = StringIO()
        writer = csv.DictWriter(table, [f.name for f in fields(Proof)], lineterminator="\n")
        writer.writeheader()
        writer.writerows({k: as_words(v) if isinstance(v, str) else v for k, v in row.items()} for row in rows)
        with last():
            write_whole(folder / "audit.json", json.dumps(whole, indent=1, ensure_ascii=False) + "\n")
            write_whole(folder / "audit.csv", table.getvalue())


def _cell(row: Proof) -> str:
    number = f"{row.measured:.1e}" if math.isfinite(row.measured) else "–"
    mark = {"failed": " FAILED", "declared": " declared"}.get(row.verdict, "")
    return f"[{STYLE[row.verdict]}]{number}{mark}[/]"


def _words(value: object) -> str:
    return "; ".join(map(str, value)) if isinstance(value, list) else str(value)


def _finite(value: object) -> object:
    return None if isinstance(value, float) and not math.isfinite(value) else value
