"""A first scenario from what a team has: a URDF and recordings. Every guess says in a comment that it is one."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from shlex import quote

from realitygap_engines.errors import ModelError
from realitygap_engines.model.hold import hold
from realitygap_engines.model.read import read_model
from realitygap_engines.model.robot import Joint, Model

from realitygap.files.errors import InputError
from realitygap.files.home import at_home
from realitygap.files.interrupted import last
from realitygap.files.unfinished import UNFINISHED
from realitygap.files.unpacked import plain_name
from realitygap.files.whole import made, write_whole
from realitygap.init.bag_sections import bag_sections
from realitygap.init.dataset_sections import dataset_sections
from realitygap.init.degrees import in_degrees
from realitygap.init.folders import recordings_in
from realitygap.init.measured_gains import measured_gains
from realitygap.init.repeated import repeated, without_copies
from realitygap.init.robot_guess import base_of, servo_lines
from realitygap.init.sections import Sections, quoted, relative
from realitygap.init.streamed import between_samples
from realitygap.init.table_sections import table_sections
from realitygap.recording import Recording, read_recording, reader_of
from realitygap.recording.align import RecordedRun
from realitygap.recording.lack import noticed
from realitygap.scenario.file import load_scenario
from realitygap.scenario.schema import Scenario
from realitygap.scenario.schema_file import COMMENT, SCHEMA
from realitygap.scenario.which_file import RECORDINGS, ROBOTS

GUESS = "# GUESS: "
NO_MOTION = (
    "what drives the joints: motion: {recorded: COMMANDS} or {keyframes: FILE}, or {followed: true} with recorded "
    "efforts"
)
HINT = "add use: train or use: held_out; without them a diagnosis keeps every third motion to judge on"


@dataclass(frozen=True)
class Draft:
    """A scenario that was written, and what the user should know of it."""

    path: Path
    guessed: list[str]
    told: list[str]
    driven: bool = True

    def lines(self) -> list[str]:
        """All of it for a terminal."""
        run = f"realitygap run {quote(str(self.path))} --engine mujoco    (without --engine: in all of them)"
        return [
            f"wrote {self.path}",
            *(f"guessed: {line}" for line in self.guessed),
            *(line if line.startswith("not used") else f"note: {line}" for line in self.told),
            f"next: {run}" if self.driven else f"next: say in {self.path} {NO_MOTION}; then {run}",
        ]


def init(urdf: Path, bags: list[Path], out: Path, packages: Mapping[str, Path] | None = None) -> Draft:
    """Write `scenario.yaml` into a folder, and the JSON Schema by which editors check it.

    Args:
        urdf: the robot.
        bags: bags, bag folders, tables, data sets or folders of several of them, in the order of the runs.
        out: the folder, made where it is not there.
        packages: where `package://NAME/` lies.

    Raises:
        InputError: for a URDF or recording that cannot be used, a recording with none of the robot's joints, or a
            scenario that is already there.
    """
    target = out / "scenario.yaml"
    if target.exists():
        raise InputError(f"{target}: is already there; remove it or give another folder with --out")
    if not bags:
        raise InputError(f"{urdf}: no recordings were given; expected at least one bag or table after the URDF")
    bags, held_in = recordings_in(bags)
    _check_given(urdf, bags)
    packages = packages or {}
    model, fixed = _model(urdf, packages)
    sections = _sections(urdf, bags, out, model)
    sections = _without_followers(sections, model)
    rest = {i: _rest(joint) for i, joint in enumerate(model.joints) if joint.name in sections.held}
    held = {model.joints[i].name: angle for i, angle in rest.items()}
    model = hold(model, rest)
    named = {path.resolve(): path for path in bags}  # as whoever reads a sentence knows them
    with made(out):
        draft = out / f"{UNFINISHED}scenario.yaml"
        try:
            text = _text(urdf, out, packages, model, fixed, sections, held)
            draft.write_text(text, encoding="utf-8")
            loaded, every = load_scenario(draft), list[RecordedRun]()
            for case in (cases := loaded.cases()):
                path = named.get(case.path.resolve(), case.path)
                every.append(RecordedRun(case.name, _read(path, bags[0], case.scenario, model, target)))
            better, runs, copies = without_copies(sections, every)
            by_path = {case.path: run.recording for case, run in zip(cases, every, strict=True)}
            told = [
                *held_in,
                *sections.unsure,
                *_following(sections, model).values(),
                *sections.told,
                *copies,
                *repeated(runs),
                *noticed((run.name, lack) for run in runs for lack in run.recording.absent),
            ]
            recordings = [run.recording for run in runs]
            if (turned := in_degrees(loaded, better, model, by_path)) is not None:
                better = turned
                text = _text(urdf, out, packages, model, fixed, better, held)
                draft.write_text(text, encoding="utf-8")
                loaded = load_scenario(draft)
                recordings = [_read(c.path, bags[0], c.scenario, model, target) for c in loaded.cases()]
            better = between_samples(loaded, better, recordings) or better
            gains = measured_gains(loaded, model.joints, recordings, held=better.motion.holds)
            better = replace(better, gains=gains) if gains else better
            if better is not sections:
                text = _text(urdf, out, packages, model, fixed, better, held)
                draft.write_text(text, encoding="utf-8")
            with last():
                write_whole(out / SCHEMA.name, SCHEMA.read_text(encoding="utf-8"))
                draft.rename(target)
        finally:
            draft.unlink(missing_ok=True)
    driven = not model.joints or loaded.scenario.motion is not None
    return Draft(target, _guesses(text), told, driven)


def _read(path: Path, first: Path, scenario: Scenario, model: Model, target: Path) -> Recording:
    """A recording as the draft says it; what it lacks of that is told of the recording, as no draft is there to change.

    Raises:
        InputError: for a recording that cannot be read, or that does not hold what the first one does.
    """
    try:
        return read_recording(path, scenario, model.joint_names, file=target, mimics=model.mimics, limits=model.limits)
    except InputError as error:
        lacking = str(error).removeprefix(f"{target}: ")
        if lacking == str(error):
            raise
        raise InputError(
            f"{path}: does not fit the scenario as {first} makes it: {lacking}; expected recordings with the same "
            "signals: leave this one out, or write a scenario of its own for it"
        ) from None


def _check_given(urdf: Path, bags: list[Path]) -> None:
    """Make sure that the robot comes first and every recording once, which reading them would tell less plainly."""
    if plain_name(urdf).suffix.lower() in RECORDINGS and urdf.is_file():
        raise InputError(f"{urdf}: is a recording; expected the robot's file first, and its recordings after it")
    for path in bags:
        if path.suffix.lower() in ROBOTS and path.is_file():
            raise InputError(f"{path}: is a robot's file; expected recordings after {urdf}, and one robot alone")
    real = [path.resolve() for path in bags]
    double = next((path for path, where in zip(bags, real, strict=True) if real.count(where) > 1), None)
    if double is not None:
        raise InputError(f"{double}: is given {real.count(double.resolve())} times; expected every recording once")


def parse_packages(stated: list[str]) -> dict[str, Path]:
    """Packages by name from `NAME=DIR`.

    Raises:
        InputError: for another form, or a folder that is not there.
    """
    found = {}
    for text in stated:
        name, _, folder = text.partition("=")
        if not name or not at_home(folder).is_dir() or not folder:
            raise InputError(f"--package: found {text}; expected NAME=DIR, where DIR is a folder that is there")
        found[name] = at_home(folder)
    return found


def _model(urdf: Path, packages: Mapping[str, Path]) -> tuple[Model, str | None]:
    """The robot, and why its base must be fixed (None: it need not be). No mesh is needed for a first guess."""
    try:
        return read_model(urdf, floating=True, packages=packages, contact_links=[]), None
    except ModelError as floating:
        try:
            return read_model(urdf, floating=False, packages=packages, contact_links=[]), "the root link has no mass"
        except ModelError as fixed:  # of a single body, which a fixed base would keep from moving, the other counts
            raise InputError(str(floating if "nothing can move" in str(fixed) else fixed)) from None


def _rest(joint: Joint) -> float:
    """Where a joint that was not recorded is held [rad or m]: at 0, or the limit that is nearest to it."""
    return float(min(max(0.0, joint.lower), joint.upper))


def _without_followers(sections: Sections, model: Model) -> Sections:
    """The sections in which no joint is held that mimics another: where that one is, or is held, tells where it is."""
    held = tuple(joint for joint in sections.held if joint not in model.mimics)
    followers = tuple(joint for joint in sections.held if joint in model.mimics)
    unmeasured = {joint: where for joint, where in sections.unmeasured.items() if joint in held}
    return replace(sections, held=held, followers=followers, unmeasured=unmeasured)


def _following(sections: Sections, model: Model) -> dict[str, str]:
    """A sentence on every joint that was not recorded and follows another that moves."""
    return {
        joint: f"{joint} was not recorded: it follows {mimic.joint}, and is simulated and not compared"
        for joint, mimic in model.mimics.items()
        if joint in sections.followers
    }


def _sections(urdf: Path, bags: list[Path], out: Path, model: Model) -> Sections:
    kinds = {path: reader_of(path) for path in bags}
    for path, kind in kinds.items():
        if kind != kinds[bags[0]]:
            raise InputError(
                f"{path}: is another kind of recording than {bags[0]}; expected one kind in a scenario: write one each"
            )
    if kinds[bags[0]] == "lerobot":
        return dataset_sections(bags, model, urdf, out)
    if kinds[bags[0]] == "table":
        return table_sections(bags, model.joint_names, urdf, out)
    return bag_sections(bags, model.joint_names, urdf, out)


def _text(
    urdf: Path,
    out: Path,
    packages: Mapping[str, Path],
    model: Model,
    fixed: str | None,
    sections: Sections,
    held: Mapping[str, float],
) -> str:
    base, reason = base_of(model, fixed, sections.moving_base)
    lines = [
        COMMENT,
        "# Written by `realitygap init`. What says GUESS was not in the files: check it, then compare.",
        f"name: {quoted(urdf.stem)}",
        "robot:",
        f"  urdf: {quoted(relative(urdf, out))}",
    ]
    if packages:
        inner = ", ".join(f"{quoted(name)}: {quoted(relative(path, out))}" for name, path in packages.items())
        lines.append(f"  packages: {{{inner}}}")
    lines.append(f"  base: {base}  {GUESS}{reason}")
    if held:
        inner = ", ".join(f"{quoted(name)}: {angle:g}" for name, angle in held.items())
        lines += [f"  # {sentence}" for sentence in sections.unsure]
        lines.append(f"  hold: {{{inner}}}  {GUESS}where they stand [rad or m], as they were not recorded")
    if model.joints:
        servos = (
            [] if sections.followed else ["", *servo_lines(model, sections.meaning, sections.robot, sections.gains)]
        )
        lines += [*servos, "", sections.motion.line]
    ground = "none" if base == "fixed" else "flat"
    lines += ["", f"ground: {ground}  {GUESS}flat, grass, or friction, stiffness and damping by numbers"]
    hint = f"  # {HINT}" if len(sections.runs) > 1 else ""
    lines += ["physics: {step_rate: 1000}", "", "recordings:", *sections.table, *sections.recordings]
    if following := _following(sections, model):
        lines += [f"  # {sentence}" for sentence in following.values()]
        lines.append(f"  exclude: [{', '.join(map(quoted, following))}]")
    lines += [f"  runs:{hint}", *sections.runs]
    return "\n".join([*lines, ""])


def _guesses(text: str) -> list[str]:
    """The lines of a draft that say GUESS, as a terminal shows them."""
    marked = [line.strip().removeprefix("- ") for line in text.splitlines() if GUESS in line.lstrip(" #")]
    return [line.replace(f"  {GUESS}", " (", 1) + ")" for line in marked]
