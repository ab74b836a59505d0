"""`make fuzz`: thousands of cases of every kind. Prints every way in which one breaks, and keeps its files.

python tests/fuzz/run.py --cases 10000 --seed 1 --keep results/runs/fuzz [--kind urdf ...]
"""

import argparse
import json
import re
import shutil
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

from fuzz.judge import Zygote, judged, zygote
from fuzz.kinds import KINDS, RUN, Case, results_of
from fuzz.template import files, written
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import seed as seeded
from hypothesis.strategies import SearchStrategy


def told(error: AssertionError) -> str:
    """What broke, without the numbers that differ from case to case."""
    lines = [line for line in str(error).splitlines() if line.strip()]
    return re.sub(r"[\d.]+|0x[0-9a-f]+", "#", f"{lines[0].split(':', 1)[-1][:60]} … {lines[-1][:200]}")


def say(line: str) -> None:
    """A line, at once."""
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


@dataclass
class Seen:
    """What was seen: cases, in which ways they broke and how often, the longest and the largest; `keep` takes files."""

    keep: Path | None
    cases: int = 0
    broken: dict[str, int] = field(default_factory=dict)
    worst: dict[str, float] = field(default_factory=lambda: {"seconds": 0.0, "memory": 0.0})

    def note(self, kind: str, content: dict[str, bytes], arguments: list[str], error: AssertionError) -> None:
        """Remember how a case broke; the first of every way is told and kept."""
        what = f"{kind}: {told(error)}"
        self.broken[what] = self.broken.get(what, 0) + 1
        if self.broken[what] == 1:
            say(f"BROKEN {kind}: {error}\n")
            if self.keep:
                place = self.keep / f"{kind}_{len(self.broken)}"
                place.parent.mkdir(parents=True, exist_ok=True)
                written(place, content)
                (place / "command.json").write_text(json.dumps([arguments, str(error)], indent=1))


def explore(
    process: Zygote, folder: Path, kind: str, cases: SearchStrategy[Case], args: argparse.Namespace, seen: Seen
) -> None:
    """Try the cases of one kind."""

    @seeded(args.seed)
    @settings(
        max_examples=max(args.cases // len(args.kind), 1),
        phases=[Phase.generate],
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
    )
    @given(cases)
    def tried(case: Case) -> None:
        shutil.rmtree(folder, ignore_errors=True)
        content, arguments = case
        written(folder, content)
        seen.cases += 1
        try:
            done = judged(process, folder, arguments)
        except AssertionError as error:
            seen.note(kind, content, arguments, error)
            return
        for key in seen.worst:
            seen.worst[key] = max(seen.worst[key], done[key])

    tried()


def main() -> int:
    """The number of ways in which cases broke."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--cases", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path)
    parser.add_argument("--kind", nargs="+", default=[*KINDS, "results"])
    args = parser.parse_args()
    seen = Seen(args.keep)
    with zygote() as process, tempfile.TemporaryDirectory() as name:
        made = Path(name) / "made"
        written(made, files())
        assert judged(process, made, RUN)["status"] == 0
        kinds = KINDS | {"results": lambda: results_of(made / "new")}
        for kind in args.kind:
            began = time.monotonic()
            explore(process, Path(name) / "case", kind, kinds[kind](), args, seen)
            say(f"{kind}: {time.monotonic() - began:.0f} s")
    for what, count in seen.broken.items():
        say(f"{count:5} {what}")
    say(
        f"seed {args.seed}: {seen.cases} cases, {sum(seen.broken.values())} broken in {len(seen.broken)} ways; at most "
        f"{seen.worst['seconds']:.1f} s and {seen.worst['memory']} MiB"
    )
    return len(seen.broken)


if __name__ == "__main__":
    sys.exit(bool(main()))
