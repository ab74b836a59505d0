"""Diagnosis as a library: verdict, findings and the mended model, of what `diagnosis.json` promises."""

from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

from realitygap.diagnose.result.diagnosis import Diagnosis
from realitygap.diagnose.result.revise import write_revised
from realitygap.diagnose.result.workflow import diagnosed, write_diagnosis
from realitygap.files.errors import InputError
from realitygap.files.progress import Progress
from realitygap.files.result_kind import check_free
from realitygap.files.whole import check_writable
from realitygap.scenario.engine_names import given_engines
from realitygap.scenario.file import Source, load_scenario
from realitygap.scenario.schema import EffectSpec

Pair = tuple[float, float]
"""A gap before and after a finding, in floors: 1 cannot be told from a perfect model."""


@dataclass(frozen=True)
class Finding:
    """An effect that the model lacks.

    Attributes:
        effect, target: as in a scenario file.
        parameters: values by name, in SI units; of an `effort_map` lists, as in a scenario.
        intervals: 95 % intervals by parameter; both ends are the value where it was not fitted.
        units: of the parameters.
        held_out: the gap before and after, on runs that were not fitted.
        engines: the same in every engine where it was confirmed.
        cannot_tell_from: sentences on effects that would explain the recordings as well, with the reason.
    """

    effect: str
    target: str | tuple[str, ...]
    parameters: dict[str, Any]
    intervals: dict[str, tuple[Any, Any]]
    units: dict[str, str]
    held_out: Pair
    engines: dict[str, Pair]
    cannot_tell_from: tuple[str, ...]

    def __repr__(self) -> str:
        told = {n: f"{v:.4g}" if isinstance(v, float) else str(v) for n, v in self.parameters.items()}
        values = ", ".join(f"{n} {v} {self.units[n]}".rstrip() for n, v in told.items())
        return f"<Finding {self.effect} at {_shown(self.target)}: {values}>"

    @property
    def spec(self) -> EffectSpec:
        """The finding as an effect of a scenario, for `simulate(..., effects=[finding.spec])`."""
        target = self.target if isinstance(self.target, str) else list(self.target)
        return EffectSpec.model_validate({"effect": self.effect, "target": target, **self.parameters})


@dataclass(frozen=True, repr=False)
class Revised:
    """The mended model: the scenario with the findings in it, and what its laws are off by, in its URDF where that can
    say them.
    """

    diagnosis: Diagnosis

    def __repr__(self) -> str:
        return f"<Revised {self.diagnosis.problem.file.scenario.name}: save(FOLDER) writes it>"

    def save(self, folder: str | PathLike[str]) -> Path:
        """Write `scenario.yaml` and the URDFs that it needs, and return the scenario's path: it runs as it is.

        Without a finding it is the scenario as it was, with its paths leading from there.

        Raises:
            InputError: for a folder that cannot be written, or the scenario's own, whose files it would replace.
        """
        place = Path(folder).absolute()
        own = self.diagnosis.problem.file.path.absolute()
        if place.resolve() == own.parent.resolve():
            raise InputError(f"save: {folder} is the folder of {own.name}, which would be replaced; expected another")
        check_writable(place, "save")
        return write_revised(self.diagnosis.problem, self.diagnosis.mended, place)[0]


@dataclass(frozen=True, repr=False)
class Diagnosed:
    """What a diagnosis found.

    Attributes:
        result: all of it, for whoever wants to look inside.
        content: what `diagnosis.json` says, but for the files of the mended model.
    """

    result: Diagnosis
    content: dict[str, Any]

    def __repr__(self) -> str:
        found = ", ".join(f"{f.effect} at {_shown(f.target)}" for f in self.findings) or "nothing named"
        return f"<Diagnosed {self.content['scenario']}: {self.verdict}; {found}>"

    @property
    def verdict(self) -> str:
        """explained, partly explained, no gap or unexplained."""
        return str(self.content["verdict"])

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What is missing, in the order in which it was found."""
        return tuple(_finding(told) for told in self.content["findings"])

    @property
    def adjusted(self) -> tuple[Finding, ...]:
        """What the laws of the named model are off by, as ordinary laws are: no findings, but in the mended model."""
        return tuple(_finding(told) for told in self.content["adjusted"])

    @property
    def gap(self) -> dict[str, Pair]:
        """The gap before and after, of the runs for `train` and those `held_out`."""
        return {use: _pair(self.content["gap"][use]) for use in ("train", "held_out")}

    @property
    def experiment(self) -> str:
        """What to record to settle what cannot be told apart; empty where there is nothing."""
        return str(self.content["experiment"])

    @property
    def revised(self) -> Revised:
        """The mended model."""
        return Revised(self.result)

    def save(self, folder: str | PathLike[str]) -> Path:
        """Write what the command writes: `diagnosis.json`, the page, the figures and `revised/`. Returns the folder.

        Raises:
            InputError: for a folder that cannot be written, or holds the result of another command.
        """
        out = Path(folder)
        check_writable(out, "save")
        check_free(out, "diagnose", "save")
        write_diagnosis(self.result, out)
        return out


def diagnose(
    scenario: Source,
    engines: str | Sequence[str] | None = None,
    *,
    workers: int | None = None,
    progress: bool = False,
    minutes: float | None = None,
) -> Diagnosed:
    """Find what a model lacks, name it, and prove on runs that were not fitted that it helps. It takes minutes.

    Args:
        scenario: a scenario, the path of one, or a dict that says the same.
        engines: the first one searches, all confirm; None: MuJoCo searches and all that are installed confirm.
        workers: processes; None for one per core.
        progress: whether to tell on standard error what is being done.
        minutes: by the clock, after which nothing more is looked for, infinite for to the end; what was found by then
            is judged on held-out runs. None for as many simulations as take about two minutes, and longer of a robot
            with many joints (`MINUTES` and `EACH` in `realitygap.diagnose.search_budget`): every run finds the same.

    Raises:
        InputError, ModelError: for a scenario that cannot be diagnosed.
    """
    names = given_engines(engines)
    result = diagnosed(load_scenario(scenario), names, Progress(quiet=not progress), workers, minutes=minutes)
    return Diagnosed(result, result.to_json())


def _finding(told: dict[str, Any]) -> Finding:
    parameters, rivals = told["parameters"], told.get("cannot_tell_from", ())
    return Finding(
        effect=told["effect"],
        target=told["target"] if isinstance(told["target"], str) else tuple(told["target"]),
        parameters={n: p["value"] for n, p in parameters.items()},
        intervals={n: (p["low"], p["high"]) for n, p in parameters.items()},
        units={n: p["unit"] for n, p in parameters.items()},
        held_out=_pair(told["held_out"]),
        engines={name: _pair(gap) for name, gap in told["engines"].items()},
        cannot_tell_from=tuple(f"{r['effect']} at {_shown(r['target'])}: {r['why']}" for r in rivals),
    )


def _shown(target: str | Sequence[str]) -> str:
    return target if isinstance(target, str) else ", ".join(target)


def _pair(gap: dict[str, float]) -> Pair:
    return gap["before"], gap["after"]
