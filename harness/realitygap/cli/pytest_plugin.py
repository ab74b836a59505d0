"""Gaps as tests, for robot teams: every engine and recording of a scenario is one test that fails over budget.

Without a line of code, on scenario files named on the command line:

    pytest --engines mujoco,dart scenarios/kick/scenario.yaml

Or in a test file, where the path is relative to that file and the engines are those of `--engines` or all installed:

    import pytest

    @pytest.mark.realitygap("scenarios/kick/scenario.yaml")
    def test_kick(reality_gap):
        reality_gap.check()

The budget is the scenario's, or what `check(position=1.2)` says. A project that does neither is left alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from realitygap.compare.comparison import Comparison, RepeatedMotion
    from realitygap.scenario.file import ScenarioFile

OPTION = "--engines"
INI = "realitygap_engines"
FIXTURE = "reality_gap"


class OverBudget(AssertionError):
    """A gap is larger than its budget; the message says joint, signal, value, budget and floor."""


@dataclass
class RealityGap:
    """One motion of a scenario in one engine."""

    file: ScenarioFile
    motion: RepeatedMotion
    engine: str

    @property
    def name(self) -> str:
        """Engine and recording."""
        return f"{self.engine}-{self.motion.name}"

    @cached_property
    def comparison(self) -> Comparison:
        """Simulated and compared, once."""
        from realitygap.compare.comparison import compare

        return compare(self.motion, self.engine)

    def check(self, **budget: float) -> None:
        """Fail where a mean gap of moving joints exceeds its budget: position [°], velocity [°/s], effort [N·m].

        Without arguments the scenario's budget holds. What the engine cannot express is skipped.

        Raises:
            OverBudget: where the budget is exceeded, nothing was measured that it is about, or the simulation blew up.
        """
        from realitygap.compare.budget import SIGNALS, not_judged, over_budget
        from realitygap.compare.row import outcome_told
        from realitygap.compare.table import table

        unknown = [s for s in budget if s not in SIGNALS]
        if unknown:
            raise TypeError(f"check() knows {', '.join(SIGNALS)}; found {', '.join(unknown)}")
        stated = self.file.scenario.budget
        limits = budget or (stated.model_dump(exclude_none=True) if stated else {})
        if not limits:
            raise pytest.UsageError(f"{self.file.path}: budget: is missing; expected for example {{position: 1.2}}")
        done = self.comparison
        if done.outcome == "unsupported":
            pytest.skip(done.note)
        if done.outcome != "ok":
            raise OverBudget(f"{self.name}: {outcome_told(done.outcome, done.note)}")
        gaps = table(done.rows)
        lines = over_budget(gaps, limits) + not_judged(gaps, limits)
        if lines:
            raise OverBudget("\n".join(lines))


class ScenarioTest(pytest.Item):
    """The test of one engine and recording of a scenario file."""

    def __init__(self, *, gap: RealityGap, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.gap = gap

    def runtest(self) -> None:
        """Simulate, compare, and hold the gap against the scenario's budget."""
        self.gap.check()

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """A gap over budget and a budget that is missing are told by their sentence, without a traceback."""
        if isinstance(excinfo.value, OverBudget | pytest.UsageError):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, int | None, str]:
        """Where this test comes from."""
        return self.path, None, self.name


class ScenarioTests(pytest.File):
    """A scenario file as a collection of tests."""

    def collect(self) -> Iterator[ScenarioTest]:
        """One test per engine and recording."""
        for gap in gaps_of(self.path, wanted_engines(self.config) or []):
            yield ScenarioTest.from_parent(self, name=gap.name, gap=gap)

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException]) -> Any:  # type: ignore[override]  # as pytest's
        """What is wrong with a scenario is told by its sentence, without a traceback."""
        return str(excinfo.value) if isinstance(excinfo.value, pytest.UsageError) else super().repr_failure(excinfo)


def gaps_of(path: Path, names: Sequence[str], where: str = OPTION) -> list[RealityGap]:
    """Every engine and motion of a scenario; `where` says where the engines are named.

    Raises:
        pytest.UsageError: for an engine or a scenario that cannot be used, in one sentence.
    """
    from realitygap_engines import RealityGapError

    from realitygap.compare.comparison import motions_of
    from realitygap.scenario.engine_names import engine_names
    from realitygap.scenario.file import load_scenario

    try:
        file = load_scenario(path)
        found = motions_of(file)
        return [RealityGap(file, motion, engine) for engine in engine_names(names, where) for motion in found]
    except RealityGapError as error:
        raise pytest.UsageError(str(error)) from None


def wanted_engines(config: pytest.Config) -> list[str] | None:
    """The engines of `--engines` or of the ini file; None where neither is given, empty for all installed."""
    text = config.getoption(OPTION) or config.getini(INI)
    if not text:
        return None
    names = [name.strip() for name in text.split(",") if name.strip()]
    return [] if names == ["all"] else names


def pytest_addoption(parser: pytest.Parser) -> None:
    """The option and the ini key."""
    what = "engines of realitygap, separated by commas, or `all`: scenario files on the command line become tests"
    parser.getgroup("realitygap").addoption(OPTION, metavar="NAMES", help=what)
    parser.addini(INI, what, default="")


def pytest_configure(config: pytest.Config) -> None:
    """The marker."""
    config.addinivalue_line("markers", "realitygap(scenario, engines=None): a test per engine and recording")


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> pytest.Collector | None:
    """Scenario files that are named on the command line, where engines are asked for."""
    if file_path.suffix not in (".yaml", ".yml") or wanted_engines(parent.config) is None:
        return None
    named = [(parent.config.invocation_params.dir / arg.split("::")[0]).resolve() for arg in parent.config.args]
    return ScenarioTests.from_parent(parent, path=file_path) if file_path.resolve() in named else None


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """A test with the marker gets one `reality_gap` per engine and recording."""
    marker = metafunc.definition.get_closest_marker("realitygap")
    if marker is None or FIXTURE not in metafunc.fixturenames:
        return
    (scenario,) = marker.args
    names, where = wanted_engines(metafunc.config), OPTION
    if names is None:
        names, where = list(marker.kwargs.get("engines") or []), "realitygap(engines=)"
    gaps = gaps_of(metafunc.definition.path.parent / scenario, names, where)
    metafunc.parametrize(FIXTURE, gaps, ids=[g.name for g in gaps], scope="session")
