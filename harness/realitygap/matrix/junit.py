"""Which cells of a matrix exceed a budget, and the cells as test cases for build servers."""

from collections.abc import Mapping

from realitygap.compare.budget import over_budget
from realitygap.compare.junit import Case
from realitygap.matrix.collect import Collected


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


def cases(collected: Collected, over: Mapping[str, list[str]]) -> list[Case]:
    """Every cell as a test case."""
    return [
        Case(
            suite=task.file.scenario.name,
            name=task.title,
            outcome=outcome.outcome,
            note=outcome.note,
            seconds=outcome.wall if outcome.steps else None,
            over=over.get(task.key, ()),
        )
        for task, outcome in collected.cells
    ]
