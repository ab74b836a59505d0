"""A diagnosis of the bundled demo (synthetic) with any verdict, without a search, and its page as a test reads it."""

from html.parser import HTMLParser
from pathlib import Path
from typing import Any

from demo_problem import demo_problem
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.motions import residual
from realitygap.diagnose.judge.closest import Closest
from realitygap.diagnose.judge.gaps import Shown
from realitygap.diagnose.judge.held_out import Verdict
from realitygap.diagnose.judge.locate import locate
from realitygap.diagnose.judge.worsened import Worsened, in_units
from realitygap.diagnose.result.diagnosis import Diagnosis
from realitygap.diagnose.result.story import write_story
from realitygap.diagnose.search.criterion import Criterion
from realitygap.diagnose.search.found import Found
from realitygap.diagnose.search.rivals import Rival

FRICTION = Suspect("coulomb_friction", "elbow", (1,))
VERDICTS = {"explained": (9.0, 1.1), "partly explained": (9.0, 3.0), "no gap": (1.0, 1.0), "unexplained": (9.0, 9.0)}
"""Mean squared residuals before and after that lead to each verdict."""


def judged_demo() -> Any:
    """The demo with its floors, the fit of what is missing, and what was simulated before and after: no search."""
    problem = demo_problem()
    change = Change(FRICTION, (("torque", 0.6447), ("onset", 0.0), ("presliding", 0.0)), ("torque",))
    with Simulations(problem, 2) as simulations:
        criterion = Criterion(simulations, [change])
        still, done = residual(simulations, [], criterion.train), criterion.fit([change])
        assert still is not None
        assert done is not None
        base = criterion.score(Fit((), still))
        every = range(len(problem.cases))
        signals = [dict(enumerate(simulations.of(c, every))) for c in (list[Change](), done.fit.changes)]
    return problem, criterion, base, done, *signals


def told_as(judged: Any, verdict: str) -> Diagnosis:
    """The diagnosis that has a verdict; the costs are invented, everything else is not."""
    problem, criterion, base, done, before, after = judged
    floors = criterion.floors
    was, left = (dict.fromkeys(range(len(problem.cases)), cost) for cost in VERDICTS[verdict])
    named = verdict in ("explained", "partly explained")
    best = done if named else base
    rival = Rival(Suspect("viscous_friction", "elbow", (1,)), done, 0.4, 0.6)
    gains, rivals = {FRICTION: 41.0}, {FRICTION: [rival]}
    found = Found(base, best, best, 6.0, {FRICTION: 6.0}, floors, criterion, gains=gains, rivals=rivals)
    gain = Change(Suspect("controller_gain", "elbow", (1,)), (("gain", 4.0),), ("gain",))
    result = Diagnosis(
        problem=problem,
        engines=["mujoco", "dart", "drake"],
        found=found,
        changes=best.fit.changes,
        floors=floors,
        costs=(was, left),
        shown={FRICTION: Shown(3.0, 1.05, {"dart": (3.1, 1.2)})} if named else {},
        predicted=Verdict(30.0, 5.0),
        where=locate(problem, floors, before) if verdict != "no gap" else [],
        left=locate(problem, floors, before)[:1] if verdict == "partly explained" else [],
        worsened=[Worsened("shoulder", "velocity", "deg/s", 1.0, 1.4)] if named else [],
        units=in_units(problem, problem.of("held_out"), before, after),
        faults=["sines_2: 3 readings repeat the one before <them>"],
        closest=[Closest(gain, 3.0, 2.9, "it gains 2.0 in evidence over something else; a name needs 6.0")],
        before=before,
        after=after if named else before,
    )
    assert result.verdict == verdict
    return result


class Page(HTMLParser):
    """What a test wants to know of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.ids: list[str | None] = []
        self.links: list[str | None] = []
        self.loads: list[str] = []
        self.open: list[str] = []
        self.text = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = dict(attrs)
        if "id" in values:
            self.ids.append(values["id"])
        if tag == "a":
            self.links.append(values["href"])
        if tag in ("script", "link", "img", "iframe", "object", "embed", "video"):
            self.loads.append(tag)
        if tag not in ("meta", "br", "path", "use", "rect", "link"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if tag in ("path", "use", "rect"):
            return
        assert self.open, f"</{tag}> without a start"
        assert self.open.pop() == tag

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        pass

    def handle_data(self, data: str) -> None:
        if "style" not in self.open:
            self.text += data + " "


def page_of(result: Diagnosis, folder: Path) -> tuple[str, Page, str]:
    """Its text, what a test wants to know of it, and its words."""
    text = write_story(result, folder).read_text(encoding="utf-8")
    page = Page(text)
    return text, page, " ".join(page.text.split())
