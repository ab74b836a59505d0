"""`realitygap bench ground`: friction, stiffness and damping of the ground from tosses, for every engine.

Fitted on the tosses that are for training, judged on the others. What a ground parameter means is physics, the same in
every engine; what the best one is differs, because every engine resolves an impact in its own way.
"""

import csv
import io
import multiprocessing
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import realitygap_engines as engines
from pydantic import AfterValidator, Field
from realitygap_engines import Ground
from realitygap_engines.model.robot import Array
from scipy.optimize import minimize
from scipy.stats import qmc

from realitygap.bench.summary import Summary
from realitygap.bench.toss import toss_errors
from realitygap.files.errors import InputError
from realitygap.files.lifeline import end_with, ended_with_it
from realitygap.files.progress import Progress
from realitygap.files.validation import validate
from realitygap.files.yaml_file import load_yaml
from realitygap.scenario.file import load_scenario, resolve_path
from realitygap.scenario.section import Patterns, Positive, Section
from realitygap.scenario.which_file import check_kind
from realitygap.simulate.experiment import Experiment, experiments


def _increasing(bounds: tuple[float, float]) -> tuple[float, float]:
    if not bounds[0] < bounds[1]:
        raise ValueError(f"bounds {list(bounds)} end before they start")
    return bounds


Bounds = Annotated[tuple[Positive, Positive], AfterValidator(_increasing)]
FEW = 50
"""Tosses that the sample is judged by, from which the search starts."""


class GroundBench(Section):
    """What is fitted, within which bounds, and what others published."""

    scenario: str = Field(description="scenario of a free body with recordings for training and held out")
    engines: Patterns | None = Field(default=None, description="engines (default: all installed)")
    friction: Bounds = Field(default=(0.05, 1.0), description="bounds of the pair's coefficient")
    stiffness: Bounds = Field(default=(200.0, 5e4), description="bounds, N/m per contact point")
    damping: Bounds = Field(default=(2.0, 500.0), description="bounds, N·s/m per contact point")
    tosses: Annotated[int, Field(gt=0)] = Field(default=80, description="tosses that the search looks at")
    samples: Annotated[int, Field(gt=0)] = Field(default=32, description="grounds that are tried before the descent")
    published: dict[str, Positive] = Field(default={}, description="e_q of others by engine, to stand beside")


@dataclass(frozen=True)
class GroundFit:
    """The ground found for one engine, and e_q of tosses.

    Attributes:
        engine: its name.
        ground: fitted to the tosses for training.
        train: e_q of every toss for training.
        held_out: and of every toss held out.
        impact: mean over those held out, judged from the last sample before the impact on.
        rigid: mean over those held out, on rigid ground.
        compliant: whether the engine has soft ground.
    """

    engine: str
    ground: Ground
    train: Array
    held_out: Array
    impact: float
    rigid: float
    compliant: bool


def run(bench: Path, out: Path, progress: Progress | None = None, workers: int | None = None) -> Summary:
    """Fit the ground in every engine and write the table of grounds.

    Args:
        bench: the bench file.
        out: folder that the table is written to.
        progress: told of every engine that is done.
        workers: processes, one per engine at a time; None is one per core.

    Raises:
        InputError: one sentence on what cannot be used.
    """
    raw = load_yaml(bench)
    check_kind(bench, "a bench of a ground", raw)
    spec = validate(bench, GroundBench, raw)
    train, held_out = _tosses(bench, spec)
    names = spec.engines or engines.available()
    fits, swapped = _fits(names, spec, train, held_out, progress or Progress(quiet=True), workers)
    summary = Summary()
    summary.section("Ground from tosses: e_q, mean over tosses")
    summary.lines.append(
        f"{len(train)} tosses to fit, {len(held_out)} held out; rigid: held out, friction of the fit, no compliance; "
        "from impact: held out, judged from the last sample before the impact on; both ways: all tosses, each on the "
        "ground fitted to the part that it is not in, ± one standard error"
    )
    header = ["engine", "friction", "stiffness N/m", "damping N·s/m", "fitted", "held out", "from impact", "rigid"]
    header += ["both ways", "±", "published"]
    lines = [_cells(f, s) for f, s in zip(fits, swapped, strict=True)]
    rows = [[*x, f"{p:.3f}" if (p := spec.published.get(x[0])) else "-"] for x in lines]
    summary.table(header, rows)
    for f in fits:
        if not f.compliant:
            summary.lines.append(f"{f.engine} has no soft ground: its friction alone was fitted")
    table = io.StringIO()
    writer = csv.writer(table, lineterminator="\n")
    writer.writerows([header[:-1], *lines])
    summary.write(out / "ground.csv", table.getvalue())
    summary.write(out / "summary.txt", "\n".join(summary.lines) + "\n")
    return summary


def _fits(
    names: Sequence[str],
    spec: GroundBench,
    train: Sequence[Experiment],
    held_out: Sequence[Experiment],
    progress: Progress,
    workers: int | None,
) -> tuple[list[GroundFit], list[GroundFit]]:
    """The fits, and those with the two parts of the tosses swapped."""
    count = min(workers or len(os.sched_getaffinity(0)), 2 * len(names))
    # Forked before an engine is loaded; a fork afterwards would share its threads' locks.
    with (
        progress.task("fitting the ground", 2 * len(names)) as advance,
        ProcessPoolExecutor(
            count, multiprocessing.get_context("fork"), initializer=end_with, initargs=(os.getpid(),)
        ) as pool,
        ended_with_it(pool),
    ):
        fits = [pool.submit(fit, name, spec, train, held_out) for name in names]
        swapped = [pool.submit(fit, name, spec, held_out, train) for name in names]
        for future in as_completed([*fits, *swapped]):
            advance(future.result().engine)
        return [f.result() for f in fits], [f.result() for f in swapped]


def _tosses(bench: Path, spec: GroundBench) -> tuple[list[Experiment], list[Experiment]]:
    path = resolve_path(bench, spec.scenario, "scenario")
    file = load_scenario(path)
    if file.scenario.robot.base != "free":
        raise InputError(f"{path}: robot.base: found {file.scenario.robot.base}; expected free, a body that is thrown")
    found = experiments(file)
    parts = [e for e in found if e.use == "train"], [e for e in found if e.use == "held_out"]
    for use, part in zip(("train", "held_out"), parts, strict=True):
        if not part:
            raise InputError(
                f"{path}: recordings.runs: found none with use: {use}; expected some to fit and some to judge"
            )
    return parts


def _cells(f: GroundFit, swapped: GroundFit) -> list[str]:
    soft = [f"{f.ground.stiffness:.4g}", f"{f.ground.damping:.4g}"] if f.compliant else ["-", "-"]
    unseen = np.concatenate([f.held_out, swapped.held_out])
    means = [f.train.mean(), f.held_out.mean(), f.impact, f.rigid, unseen.mean(), unseen.std() / np.sqrt(len(unseen))]
    return [f.engine, f"{f.ground.friction:.4g}", *soft, *(f"{e:.3f}" for e in means)]


def fit(engine: str, spec: GroundBench, train: Sequence[Experiment], held_out: Sequence[Experiment]) -> GroundFit:
    """The ground of one engine with the smallest mean e_q of training tosses."""
    rate = train[0].scenario.physics.step_rate
    part = train[:: max(len(train) // spec.tosses, 1)]

    def errors(ground: Ground, tosses: Sequence[Experiment]) -> Array:
        return toss_errors(engine, ground, tosses, rate)[:, 0]

    def error(ground: Ground, tosses: Sequence[Experiment]) -> float:
        return float(errors(ground, tosses).mean())

    few = part[:: max(len(part) // FEW, 1)]
    bounds = [spec.friction, spec.stiffness, spec.damping]
    compliant = engines.load(engine).capabilities()["soft_ground"].level != "no"
    best = descend(
        bounds if compliant else bounds[:1],
        lambda x: error(Ground(*x), few),
        lambda x: error(Ground(*x), part),
        spec.samples,
    )
    ground = Ground(*best)
    judged = toss_errors(engine, ground, held_out, rate)
    return GroundFit(
        engine,
        ground,
        errors(ground, train),
        judged[:, 0],
        float(judged[:, 1].mean()),
        error(Ground(ground.friction), held_out),
        compliant,
    )


def descend(
    bounds: Sequence[Bounds], rough: Callable[[list[float]], float], error: Callable[[list[float]], float], samples: int
) -> list[float]:
    """The parameters with the smallest error: Nelder and Mead in their logarithms, from the best of an even sample.

    Args:
        bounds: of every parameter.
        rough: what the sample is judged by.
        error: what is made small.
        samples: how many points the sample has; a power of two is the most even.
    """
    low, high = np.log(np.array(bounds)).T

    def parameters(x: Array) -> list[float]:
        return [float(v) for v in np.exp(np.clip(x, low, high))]

    points = qmc.scale(qmc.Sobol(len(bounds), seed=0).random(samples), low, high)
    start: Array = points[int(np.argmin([rough(parameters(x)) for x in points]))]
    simplex = np.vstack([start, start + np.diag(np.minimum(0.3, 0.1 * (high - low)))])

    def of(x: Array, /) -> float:
        return error(parameters(x))

    found = minimize(
        of,
        start,
        method="Nelder-Mead",
        options={"initial_simplex": simplex, "xatol": 0.02, "fatol": 1e-3, "maxfev": 25 * len(bounds)},
    )
    return parameters(found.x)
