"""What a bench procedure found: text for the terminal and the files that it wrote."""

from dataclasses import dataclass, field
from pathlib import Path


@dataclass
class Summary:
    """The result of `run`: printable `lines` and the `files` written."""

    lines: list[str] = field(default_factory=list)
    files: list[Path] = field(default_factory=list)

    def section(self, title: str) -> None:
        """A heading, with an empty line before it."""
        self.lines += ([""] if self.lines else []) + [title, "-" * len(title)]

    def table(self, header: list[str], rows: list[list[str]]) -> None:
        """A table with aligned columns: text to the left, everything after the first column to the right."""
        widths = [max(len(row[i]) for row in [header, *rows]) for i in range(len(header))]
        for row in [header, *rows]:
            cells = [row[0].ljust(widths[0]), *(cell.rjust(w) for cell, w in zip(row[1:], widths[1:], strict=True))]
            self.lines.append("  ".join(cells).rstrip())

    def write(self, path: Path, text: str) -> None:
        """Write a text file and remember it."""
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        self.files.append(path)
