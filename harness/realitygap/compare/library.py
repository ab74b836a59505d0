"""Comparison as a library: a scenario in several engines, beside what was measured."""

from collections.abc import Sequence
from dataclasses import dataclass

import pandas as pd

from realitygap.compare.comparison import Comparison, motions_of
from realitygap.compare.comparison import compare as compare_one
from realitygap.compare.table import means, table
from realitygap.files.found import part_of
from realitygap.files.progress import Progress
from realitygap.scenario.engine_names import engine_names, given_engines
from realitygap.scenario.file import ScenarioFile, Source, load_scenario
from realitygap.trace.trace import Trace


@dataclass(frozen=True)
class Compared:
    """A scenario in several engines, beside what was measured.

    Attributes:
        scenario: what was simulated.
        comparisons: one per engine and motion, in that order.
        gaps: the table of `gaps.csv`: one row per engine, recording, joint and signal, beside both floors. A cell that
            failed has rows with the outcome, the reason and infinite gaps.
    """

    scenario: ScenarioFile
    comparisons: tuple[Comparison, ...]
    gaps: pd.DataFrame

    def __repr__(self) -> str:
        engines = list(dict.fromkeys(c.cell.engine for c in self.comparisons))
        failed = sum(c.outcome != "ok" for c in self.comparisons)
        end = f", {part_of(failed, len(self.comparisons), 'cell')} failed" if failed else ""
        return f"<Compared {self.scenario.scenario.name} in {', '.join(engines)}: {len(self.gaps)} rows{end}>"

    @property
    def means(self) -> pd.DataFrame:
        """Means over joints as the thesis takes them, by engine, recording, group (moving, unmoving, base), signal."""
        return means(self.gaps)

    @property
    def simulated(self) -> dict[tuple[str, str], Trace]:
        """What was simulated, by engine and motion; of repetitions the mean, on the first one's clock."""
        return {(c.cell.engine, _motion(c)): c.simulated for c in self.comparisons if c.simulated is not None}

    @property
    def measured(self) -> dict[str, Trace]:
        """What was measured in the judged window, by motion; of repetitions the mean."""
        return {_motion(c): c.measured for c in self.comparisons if c.measured is not None}


def _motion(comparison: Comparison) -> str:
    return comparison.cell.recording or comparison.cell.scenario


def compare(
    scenario: Source, engines: str | Sequence[str] | None = None, *, floors: bool = True, progress: bool = False
) -> Compared:
    """Every motion of a scenario in every engine, compared with what was measured.

    Args:
        scenario: a scenario, the path of one, or a dict that says the same.
        engines: their names, or one; None: all that are installed.
        floors: whether to simulate again with half the step for the numerical floor, which takes twice as long again.
        progress: whether to tell on standard error how far it is.

    Raises:
        InputError, ModelError: for whatever is wrong with the scenario, its files, or an engine's name. What an engine
            cannot express and a simulation that blows up are outcomes in the table.
    """
    names = engine_names(given_engines(engines), "engines")
    file = load_scenario(scenario)
    motions = motions_of(file)
    done = []
    with Progress(quiet=not progress).task("simulating", len(names) * len(motions)) as advance:
        for name in names:
            for motion in motions:
                advance(f"{name}: {motion.name}")
                done.append(compare_one(motion, name, floors=floors))
    return Compared(file, tuple(done), table(row for c in done for row in c.rows))
