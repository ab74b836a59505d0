"""How long cells will take: from cells of the same kind that are done, else from what steps were measured to cost."""

from collections.abc import Iterable, Sequence
from statistics import median

from realitygap.compare import size
from realitygap.compare.comparison import WHOLE, whole_size
from realitygap.matrix.task import Outcome, Task
from realitygap.simulate.experiment import PART

STEP = {
    "dart": (4.0, 3.2),
    "drake": (8.0, 5.5),
    "exudyn": (16.0, 2.5),
    "mujoco": (4.0, 0.8),
    "pybullet": (5.0, 4.0),
    "simbody": (20.0, 4.0),
}
"""µs per step and further µs per joint, servos included; on a machine of 2023."""
UNKNOWN = (8.0, 5.5)
OVERHEAD = 0.1
"""s per cell for opening, comparing and writing."""
START = 8.0
"""s until the worker processes are ready and know their engines."""
BYTES = 200
"""of memory per step and joint, while a motion is simulated."""
SAMPLE = 88
"""of memory per sample and joint: measured, commanded, and simulated twice."""
LONG = 60.0
"""s: what takes longer is told before it starts."""
REPORT = 10.0
"""s for the figures and the page."""


def steps(task: Task) -> float:
    """Steps of a cell: of all repetitions, and with floors those of half the step, too; of a motion that is followed
    its samples, and with floors once more.
    """
    floors = task.floors and task.motion.measured is not None
    out = 0.0
    for e in task.motion.experiments:
        if e.followed is not None:
            out += len(e.followed.time) * (2 if floors else 1)
        else:
            out += e.duration * e.scenario.physics.step_rate * (3 if floors else 1)
    return out


def memory(task: Task) -> float:
    """Bytes that a cell takes: its recordings, and what is held of the simulation and, beside, of the measured stamps.

    What is not kept whole is held for `PART` steps.
    """
    whole = task.traces == "whole" or whole_size(task.motion) <= WHOLE
    out = 0.0
    for e in task.motion.experiments:
        steps = 0.0 if e.followed is not None else e.duration * e.scenario.physics.step_rate
        joints = len(e.plant.model.joints)
        rows = 0 if e.recording is None else len(e.recording.trace.time)
        out += joints * ((steps if whole else min(steps, PART)) * BYTES + rows * SAMPLE)
    return out


def costs(seconds: float, todo: Sequence[Task], jobs: int, there: float) -> list[str]:
    """Sentences on what is long or large, before it starts; `there` is the memory of the machine [bytes]."""
    needed = sum(sorted(map(memory, todo))[-jobs:])
    minutes = round(seconds / 60)
    lines = [f"this takes about {minutes} minute{'s' * (minutes > 1)}"] if seconds > LONG else []
    for whole in (False, True):
        told = size.told([t.motion for t in todo if t.traces and (t.traces == "whole") == whole], whole=whole)
        lines += [told] if told else []
    if needed > there / 2:
        lines.append(
            f"this takes about {needed / 1e9:.1f} GB of memory, of {there / 1e9:.1f} GB; a shorter `part` of the "
            "recordings, a lower physics.step_rate or fewer processes take less"
        )
    return lines


class StepCost:
    """What a step costs, learnt from cells that are done."""

    def __init__(self, done: Iterable[Outcome]) -> None:
        seen: dict[tuple[str, str], list[float]] = {}
        for outcome in done:
            if outcome.steps:
                seen.setdefault((outcome.cell.scenario, outcome.cell.engine), []).append(outcome.wall / outcome.steps)
        self._known = {key: median(values) for key, values in seen.items()}

    def seconds(self, task: Task) -> float:
        """What one cell takes on one core."""
        joints = len(task.motion.experiments[0].plant.model.joints)
        fixed, each = STEP.get(task.engine, UNKNOWN)
        cost = self._known.get((task.file.scenario.name, task.engine), (fixed + each * joints) * 1e-6)
        return steps(task) * cost + OVERHEAD

    def total(self, tasks: Sequence[Task], jobs: int) -> float:
        """What cells take together on `jobs` cores that have nothing else to do, and the report on them."""
        return (sum(map(self.seconds, tasks)) / max(jobs, 1) + START if tasks else 0.0) + REPORT
