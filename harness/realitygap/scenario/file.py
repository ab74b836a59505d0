"""A scenario from a file or a program: environment, paths, and what differs between its runs."""

import copy
import glob
import os
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from realitygap.files.errors import InputError, InputTypeError
from realitygap.files.found import counted, shown
from realitygap.files.unpacked import plain_name
from realitygap.files.validation import validate
from realitygap.files.yaml_file import load_yaml
from realitygap.scenario.plain import plain
from realitygap.scenario.schema import Run, Scenario
from realitygap.scenario.servos import SERVOS
from realitygap.scenario.which_file import check_kind, check_scenario_name

DATA = "REALITYGAP_DATA"
LISTS = ("effects.", "servos.", "recordings.runs.")
"""How dotted keys begin that lead into an entry of a list, also where the file has no such list."""
IN_MEMORY = "(scenario)"
"""What stands in place of a file's name in messages about a scenario that no file holds."""


@dataclass(frozen=True)
class RunCase:
    """One recording of a scenario with the scenario that holds for it (overrides applied), and the key it stands at."""

    name: str
    path: Path
    run: Run
    scenario: Scenario
    key: str


@dataclass(frozen=True)
class ScenarioFile:
    """A scenario with the file it came from; `raw` is the text as data, before defaults.

    A scenario made by a program has a `path` that does not exist, in the folder that its paths are relative to.
    """

    path: Path
    scenario: Scenario
    raw: dict[str, Any]

    def __repr__(self) -> str:
        runs = len(self.scenario.recordings.runs) if self.scenario.recordings else 0
        return f"<ScenarioFile {self.scenario.name}: {self.path}, {counted(runs, 'run')}>"

    def resolve(self, text: str, key: str) -> Path:
        """The path that a scenario's text means: environment filled in, relative to the file."""
        return resolve_path(self.path, text, key)

    def existing(self, text: str, key: str, expected: str) -> Path:
        """The same of a file that has to be there.

        Raises:
            InputError: where it is not.
        """
        path = self.resolve(text, key)
        if not path.exists():
            raise InputError(f"{self.path}: {key}: {path} does not exist; expected {expected}")
        return path

    def override(self, changes: dict[str, Any]) -> "ScenarioFile":
        """The same scenario with dotted keys changed, checked again: `{"servos.legs.gain": 2.5, "ground": "grass"}`.

        Raises:
            InputError: for a key that leads nowhere or a value that it cannot have.
        """
        told = plain(changes)
        if not isinstance(told, dict) or not all(isinstance(key, str) for key in told):
            raise InputTypeError(f"{self.path}: found {shown(told)}; expected a dict of dotted keys and their values")
        raw = apply_overrides(self.path, self.raw, told)
        return ScenarioFile(self.path, validate(self.path, Scenario, raw), raw)

    def cases(self) -> list[RunCase]:
        """Every recording with its own scenario, patterns in paths expanded, sorted by name within a pattern.

        Raises:
            InputError: for a recording that is not there or stands twice, or an override that does not fit.
        """
        recordings = self.scenario.recordings
        cases: list[RunCase] = []
        known: set[tuple[str, str, str]] = set()
        for i, run in enumerate(recordings.runs if recordings else []):
            scenario = self._scenario_of(run, f"recordings.runs[{i}].with")
            for path in self._paths(run, f"recordings.runs[{i}].path"):
                case = RunCase(_name(path, scenario), path, run, scenario, f"recordings.runs[{i}]")
                same = (
                    str(path.resolve()),
                    repr((run.window, run.episode, run.part)),
                    repr(sorted(run.overrides.items())),
                )
                if same in known:
                    raise InputError(
                        f"{self.path}: recordings.runs[{i}]: {path} stands twice with the same window and overrides; "
                        "expected every recording once"
                    )
                known.add(same)
                cases.append(case)
        return _distinct(cases)

    def _scenario_of(self, run: Run, key: str) -> Scenario:
        own = {f"recordings.{name}": value for name in ("episode", "part") if (value := getattr(run, name)) is not None}
        if not run.overrides and not own:
            return self.scenario
        try:
            return self.override(own | run.overrides).scenario
        except InputError as error:
            raise InputError(f"{self.path}: {key}: {str(error).removeprefix(f'{self.path}: ')}") from None

    def _paths(self, run: Run, key: str) -> list[Path]:
        path = self.resolve(run.path, key)
        if path.exists():
            return [path]
        if not glob.has_magic(run.path):
            raise InputError(f"{self.path}: {key}: {path} does not exist; expected a bag, a bag folder or a table")
        pattern = _filled(self.path, run.path, key)
        found = sorted(glob.glob(pattern, root_dir=self.path.parent))
        if not found:
            raise InputError(f"{self.path}: {key}: nothing matches {path}; expected at least one recording")
        return [_short(self.path.parent / p) for p in found]


def _name(path: Path, scenario: Scenario) -> str:
    """What a recording is called: its file or folder without suffix, the task or number of an episode."""
    episode = scenario.recordings.episode if scenario.recordings else None
    if path.is_file() or episode is None:
        return plain_name(path).stem if path.is_file() else path.name
    return episode if isinstance(episode, str) else f"{path.name}_{episode}"


def _distinct(cases: list[RunCase]) -> list[RunCase]:
    """The same recording used twice (other window, other overrides) gets a number behind its name."""
    seen: dict[str, int] = {}
    out = []
    for case in cases:
        seen[case.name] = count = seen.get(case.name, 0) + 1
        out.append(case if count == 1 else replace(case, name=f"{case.name}#{count}"))
    return out


Source = ScenarioFile | str | os.PathLike[str] | Mapping[str, Any]
"""A scenario, or what it is loaded from: the path of a file, or the content of one as a dict."""


def load_scenario(source: Source, folder: str | os.PathLike[str] | None = None) -> ScenarioFile:
    """The scenario in a YAML file, or in a dict that says the same.

    Args:
        source: the path of a file, a dict, or a scenario, which is returned as it is. In a dict, a `Path` stands for
            its text, and numpy's numbers and arrays for Python's.
        folder: what relative paths in a dict are relative to (default: the working directory).

    Raises:
        InputError: one sentence with file, key, what was found and what was expected.
        InputTypeError: for a source of another type, or a folder for what is no dict.
    """
    if not isinstance(folder, str | os.PathLike | None):
        raise InputTypeError(f"folder: found {shown(folder)}; expected the path of a folder")
    if folder is not None and not isinstance(source, Mapping):
        raise InputTypeError(
            f"a folder is for a scenario from a dict; the paths of {source!r} are relative to its file"
        )
    if isinstance(source, ScenarioFile):
        return source
    if isinstance(source, Mapping):
        path = Path(folder or "") / IN_MEMORY
        try:
            raw = plain(source)
        except RecursionError:
            raise InputError(f"{path}: is nested too deeply; expected a mapping of keys") from None
    elif isinstance(source, str | os.PathLike):
        path = Path(source)
        check_scenario_name(path)
        raw = load_yaml(path)
        check_kind(path, "a scenario", raw)
    else:
        raise InputTypeError(
            f"(scenario): found {type(source).__name__}; expected the path of a scenario file or a dict"
        )
    return ScenarioFile(path, validate(path, Scenario, raw), raw)


def resolve_path(file: Path, text: str, key: str) -> Path:
    """The path that the text of a key means: environment filled in, relative to the file that says it.

    Raises:
        InputError: for an environment variable that is not set, or a home folder that is not there.
    """
    return _short(file.parent / _filled(file, text, key))


def _short(path: Path) -> Path:
    """A path without the `..` in it, where that leads to the same file: from a link it leads elsewhere."""
    with suppress(OSError):
        if (short := Path(os.path.normpath(path))).samefile(path):
            return short
    return path


def _filled(file: Path, text: str, key: str) -> str:
    def value(match: re.Match[str]) -> str:
        name = match[1]
        if not os.environ.get(name):
            hint = " (the folder with the recordings)" if name == DATA else ""
            raise InputError(f"{file}: {key}: the environment variable {name} is not set{hint}; needed for {text}")
        return str(Path(os.environ[name]).absolute()) if name == DATA else os.environ[name]

    if "\0" in text:
        raise InputError(f"{file}: {key}: found {text!r}, expected a path")
    try:
        return str(Path(re.sub(r"\$\{(\w+)\}", value, text)).expanduser())
    except RuntimeError:
        raise InputError(f"{file}: {key}: found {text}, but there is no such home folder") from None


def apply_overrides(path: Path, raw: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """Raw scenario data with dotted keys changed; `servos.NAME.key` and `servos.*.key` address servos by name.

    Raises:
        InputError: for a key that leads nowhere.
    """
    out = copy.deepcopy(raw)
    for key, value in changes.items():
        _set(path, out, key.split("."), value, key)
    return out


def _set(path: Path, node: Any, parts: Sequence[str], value: Any, key: str) -> None:
    head, rest = parts[0], parts[1:]
    if isinstance(node, list):
        for item in _chosen(path, node, head, rest, key):
            _set(path, item, rest, value, key)
    elif not isinstance(node, dict):
        raise InputError(f"{path}: {key}: {head} is inside a value, expected a key of a section")
    elif not rest:
        node[head] = value
    else:
        if not isinstance(node.get(head), dict | list):
            node[head] = [] if key.startswith(LISTS) else {}
        _set(path, node[head], rest, value, key)


def _chosen(path: Path, entries: list[Any], head: str, rest: Sequence[str], key: str) -> list[Any]:
    """The entries of a list that a part of a dotted key names: by name, by number, or `*` for all that take the key."""
    names = [str(e.get("name", i)) if isinstance(e, dict) else str(i) for i, e in enumerate(entries)]
    if not rest:
        raise InputError(f"{path}: {key}: names a whole entry, expected a key in it")
    if head == "*":
        found = [e for e in entries if _takes(e, rest[0])]
        if entries and not found:
            raise InputError(f"{path}: {key}: none of {', '.join(names)} has {rest[0]}")
    else:
        found = [e for i, e in enumerate(entries) if head in (names[i], str(i))]
    if not found:
        section = key.removesuffix(".".join(["", head, *rest]))
        known = f"expected one of {', '.join([*names, '*'])}" if names else f"{section} holds none"
        raise InputError(f"{path}: {key}: there is no {head}; {known}")
    return found


def _takes(entry: Any, key: str) -> bool:
    """Whether an entry may have a key: `servos.*.gain` means the servos that can have a gain."""
    kind = SERVOS.get(str(entry.get("kind"))) if isinstance(entry, dict) else None
    return kind is None or key in kind.model_fields
