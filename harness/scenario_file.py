"""Reading a scenario file: environment, paths, overrides, and one clear sentence for what is wrong in it."""

import difflib
import glob
import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import BaseModel, ValidationError

from harness.errors import InputError
from harness.scenario import Run, Scenario

DATA = "REALITYGAP_DATA"
Checked = TypeVar("Checked", bound=BaseModel)


class _Loader(yaml.SafeLoader):
    """YAML in which a key that stands twice is an error, and text like 1e-3 is a number."""


def _mapping(loader: _Loader, node: yaml.MappingNode) -> dict[Any, Any]:
    seen: set[Any] = set()
    for key_node, _ in node.value:
        key = loader.construct_object(key_node, deep=True)  # type: ignore[no-untyped-call]
        if key in seen:
            raise yaml.constructor.ConstructorError(None, None, f"key {key!r} stands twice", key_node.start_mark)
        seen.add(key)
    return dict(loader.construct_pairs(node, deep=True))  # type: ignore[no-untyped-call]


_Loader.add_constructor(yaml.resolver.BaseResolver.DEFAULT_MAPPING_TAG, _mapping)
_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"^[-+]?(\d[\d_]*\.?[\d_]*|\.\d[\d_]*)([eE][-+]?\d+)?$|^[-+]?\.(inf|Inf|INF)$|^\.(nan|NaN|NAN)$"),
    list("-+0123456789."),
)
_Loader.yaml_implicit_resolvers = {
    first: sorted(pairs, key=lambda pair: pair[0].endswith(":float"))
    for first, pairs in _Loader.yaml_implicit_resolvers.items()
}


@dataclass(frozen=True)
class RunCase:
    """One recording of a scenario with the scenario that holds for it (overrides applied)."""

    name: str
    path: Path
    run: Run
    scenario: Scenario


@dataclass(frozen=True)
class ScenarioFile:
    """A scenario with the file it came from; `raw` is the text as data, before defaults."""

    path: Path
    scenario: Scenario
    raw: dict[str, Any]

    def resolve(self, text: str, key: str) -> Path:
        """The path that a scenario's text means: environment filled in, relative to the file."""
        return resolve_path(self.path, text, key)

    def override(self, changes: dict[str, Any]) -> "ScenarioFile":
        """The same scenario with dotted keys changed, checked again."""
        raw = apply_overrides(self.path, self.raw, changes)
        return ScenarioFile(self.path, _validate(self.path, raw), raw)

    def cases(self) -> list[RunCase]:
        """Every recording with its own scenario, patterns in paths expanded, sorted by name within a pattern."""
        recordings = self.scenario.recordings
        cases: list[RunCase] = []
        for i, run in enumerate(recordings.runs if recordings else []):
            scenario = self.override(run.overrides).scenario if run.overrides else self.scenario
            for path in self._paths(run, f"recordings.runs[{i}].path"):
                cases.append(RunCase(path.stem if path.is_file() else path.name, path, run, scenario))
        return _distinct(cases)

    def _paths(self, run: Run, key: str) -> list[Path]:
        path = self.resolve(run.path, key)
        if glob.has_magic(str(path)):
            found = [Path(p) for p in sorted(glob.glob(str(path)))]
            if not found:
                raise InputError(f"{self.path}: {key}: nothing matches {path}; expected at least one recording")
            return found
        if not path.exists():
            raise InputError(f"{self.path}: {key}: {path} does not exist; expected a bag, a bag folder or a table")
        return [path]


def _distinct(cases: list[RunCase]) -> list[RunCase]:
    """The same recording used twice (other window, other overrides) gets a number behind its name."""
    seen: dict[str, int] = {}
    out = []
    for case in cases:
        seen[case.name] = count = seen.get(case.name, 0) + 1
        out.append(case if count == 1 else RunCase(f"{case.name}#{count}", case.path, case.run, case.scenario))
    return out


def load_scenario(path: Path) -> ScenarioFile:
    """The scenario in a YAML file.

    Raises:
        InputError: one sentence with file, key, what was found and what was expected.
    """
    raw = load_yaml(path)
    return ScenarioFile(path, _validate(path, raw), raw)


def load_yaml(path: Path) -> dict[str, Any]:
    """A YAML file whose top is a mapping; keys that stand twice are errors."""
    try:
        data = yaml.load(path.read_text(encoding="utf-8"), Loader=_Loader)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); expected a YAML file") from None
    except (UnicodeDecodeError, yaml.YAMLError) as error:
        mark = getattr(error, "problem_mark", None)
        where = f" at line {mark.line + 1}" if mark else ""
        raise InputError(f"{path}: is not valid YAML{where}: {getattr(error, 'problem', None) or error}") from None
    if not isinstance(data, dict):
        raise InputError(f"{path}: holds {type(data).__name__}, expected a mapping with the keys of a scenario")
    return data


def validate(path: Path, model: type[Checked], raw: dict[str, Any]) -> Checked:
    """Checked data; the first thing that is wrong becomes one sentence."""
    try:
        return model.model_validate(raw)
    except ValidationError as error:
        raise InputError(f"{path}: {_sentence(model, error)}") from None


def _validate(path: Path, raw: dict[str, Any]) -> Scenario:
    return validate(path, Scenario, raw)


def _sentence(model: type[BaseModel], error: ValidationError) -> str:
    errors = error.errors(include_url=False)
    # of several tries at a union, the one that got deepest is what was meant
    first = max(errors, key=_depth)
    loc = [part for part in first["loc"] if not _is_tag(part)]
    key = ""
    for part in loc:
        key += f"[{part}]" if isinstance(part, int) else f".{part}" if key else str(part)
    if first["type"] == "extra_forbidden":
        known = _known_keys(model, list(first["loc"][:-1]))
        close = difflib.get_close_matches(str(loc[-1]), known, n=1)
        hint = f"; did you mean {close[0]}?" if close else ""
        return f"{key}: unknown key; known here: {', '.join(known)}{hint}"
    if first["type"] == "missing":
        return f"{key}: is missing; expected {_describe(model, list(first['loc']))}"
    if first["type"] in ("union_tag_invalid", "union_tag_not_found"):
        return f"{key}.kind: found {first['input'].get('kind') if isinstance(first['input'], dict) else first['input']!r}; expected one of dc, pid, cascade"
    message = first["msg"].removeprefix("Value error, ").replace("Input should be", "expected")
    found = repr(first["input"])
    return f"{key}: found {found if len(found) < 80 else found[:77] + '...'}; {message[0].lower() + message[1:]}"


def _depth(error: Any) -> tuple[bool, int, bool]:
    """How close one of several complaints about a union is to what the writer meant."""
    named = error["type"] == "literal_error" and isinstance(error["input"], str)
    return error["type"] == "extra_forbidden", len(error["loc"]), named


def _is_tag(part: object) -> bool:
    return isinstance(part, str) and (
        part in ("dc", "pid", "cascade")
        or part[:1].isupper()
        or part in ("float", "str", "int")
        or part.startswith(("constrained-", "literal[", "dict[", "list[", "function-"))
    )


def _known_keys(model: type[BaseModel], loc: list[Any]) -> list[str]:
    """The keys of the section at a location of the schema."""
    current: Any = model
    for part in loc:
        options = _sections(current)
        if isinstance(part, int):
            continue
        if not isinstance(current, type):
            named = [o for o in options if part in (o.__name__, _tag(o))]
            if named:
                current = named[0]
                continue
        for option in options:
            for name, field in option.model_fields.items():
                if part in (name, field.alias):
                    current = field.annotation
                    break
    return sorted({f.alias or n for o in _sections(current) for n, f in o.model_fields.items()})


def _tag(section: type[BaseModel]) -> str | None:
    kind = section.model_fields.get("kind")
    args = getattr(kind.annotation, "__args__", ()) if kind else ()
    return args[0] if args else None


def _sections(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [s for a in getattr(annotation, "__args__", ()) for s in _sections(a)]


def _describe(model: type[BaseModel], loc: list[Any]) -> str:
    for section in _sections_at(model, loc[:-1]):
        field = section.model_fields.get(str(loc[-1]))
        if field is not None and field.description:
            return field.description
    return "a value"


def _sections_at(model: type[BaseModel], loc: list[Any]) -> list[type[BaseModel]]:
    current: Any = model
    for part in loc:
        if isinstance(part, int):
            continue
        options = _sections(current)
        named = [o for o in options if part == _tag(o)]
        if named:
            current = named[0]
            continue
        found = [o.model_fields[str(part)].annotation for o in options if str(part) in o.model_fields]
        if found:
            current = found[0]
    return _sections(current)


def resolve_path(file: Path, text: str, key: str) -> Path:
    """The path that the text of a key means: environment filled in, relative to the file that says it."""

    def value(match: re.Match[str]) -> str:
        name = match[1]
        if name not in os.environ:
            hint = " (the folder with the recordings)" if name == DATA else ""
            raise InputError(f"{file}: {key}: the environment variable {name} is not set{hint}; needed for {text}")
        found = os.environ[name]
        return str(Path(found).absolute()) if name == DATA else found

    path = Path(re.sub(r"\$\{(\w+)\}", value, text)).expanduser()
    return path if path.is_absolute() else file.parent / path


def apply_overrides(path: Path, raw: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """Raw scenario data with dotted keys changed; `servos.NAME.key` and `servos.*.key` address servos by name."""
    out = _copy(raw)
    for key, value in changes.items():
        _set(path, out, key.split("."), value, key)
    return out


def _set(path: Path, node: Any, parts: list[str], value: Any, key: str) -> None:
    head, rest = parts[0], parts[1:]
    if isinstance(node, list):
        named = [x for i, x in enumerate(node) if head in ("*", str(i), isinstance(x, dict) and x.get("name"))]
        if not named:
            names = [x.get("name") or str(i) for i, x in enumerate(node) if isinstance(x, dict)]
            raise InputError(f"{path}: with: {key}: no {head} there; known: {', '.join([*names, '*'])}")
        if not rest:
            raise InputError(f"{path}: with: {key}: names a whole entry; expected a key in it")
        for item in named:
            if head == "*" and rest[0] in ("gain",) and isinstance(item, dict) and rest[0] not in item:
                continue  # `servos.*.gain` means the servos that have a gain
            _set(path, item, rest, value, key)
        return
    if not isinstance(node, dict):
        raise InputError(f"{path}: with: {key}: {head} is inside a value, not a section")
    if not rest:
        node[head] = value
        return
    if not isinstance(node.get(head), dict | list):
        node[head] = {}
    _set(path, node[head], rest, value, key)


def _copy(node: Any) -> Any:
    if isinstance(node, dict):
        return {k: _copy(v) for k, v in node.items()}
    return [_copy(v) for v in node] if isinstance(node, list) else node
