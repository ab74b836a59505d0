"""Reading YAML whose top is a mapping, with one clear sentence for what cannot be read."""

import re
from itertools import pairwise
from pathlib import Path
from typing import Any

import yaml

from realitygap.files.errors import InputError
from realitygap.files.found import kind_of
from realitygap.files.plain_file import read_written
from realitygap.files.yaml_mistake import yaml_mistake

LARGEST = 100_000
"""Values that a file may hold, also once its aliases are written out; a few lines of them can stand for billions."""


WHOLE = re.compile(r"[-+]?\d+")


class _Loader(yaml.SafeLoader):
    """YAML in which a key that stands twice is an error, and text like 1e-3 is a number; it reads `LARGEST` values."""

    def __init__(self, path: Path) -> None:
        super().__init__(read_written(path))
        self.path, self.composed = path, 0

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        self.composed += 1
        if self.composed > LARGEST:
            raise InputError(f"{self.path}: holds more than {LARGEST} values, expected a file that people write")
        return super().compose_node(parent, index)


def _mapping(loader: _Loader, node: yaml.MappingNode) -> dict[Any, Any]:
    seen: set[str] = set()
    _check_commas(loader, node)
    for key, _ in node.value:
        if not isinstance(key, yaml.ScalarNode):
            raise yaml.constructor.ConstructorError(None, None, "found a key that is not text", key.start_mark)
        if key.value in seen:
            raise yaml.constructor.ConstructorError(None, None, f"key {key.value!r} stands twice", key.start_mark)
        seen.add(key.value)
    loader.flatten_mapping(node)  # `<<: *anchor`
    return dict(loader.construct_pairs(node, deep=True))


def _check_commas(loader: _Loader, node: yaml.MappingNode) -> None:
    """In `{kp: 1,38}` a comma ends the value: the rest would be a key without one.

    Raises:
        InputError: for such a number, with how it is written.
    """
    for (key, before), (rest, after) in pairwise(node.value):
        cut = node.flow_style and after.tag.endswith(":null") and str(rest.value).isdigit()
        if cut and WHOLE.fullmatch(str(before.value)):
            raise InputError(
                f"{loader.path}: line {rest.start_mark.line + 1}: {key.value}: found {before.value},{rest.value}; "
                f"expected a number with a decimal point, as {before.value}.{rest.value}"
            )


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


def load_yaml(path: Path) -> dict[str, Any]:
    """The mapping in a YAML file; keys that stand twice are errors.

    Raises:
        InputError: for a file that cannot be read, is not YAML, holds something else, or grows without end.
    """
    try:
        loader = _Loader(path)
        node = loader.get_single_node()
        if node is not None:
            _check_size(path, node)
        data = None if node is None else loader.construct_document(node)
    except InputError:
        raise
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); expected a YAML file") from None
    except RecursionError:
        raise InputError(f"{path}: is nested too deeply; expected a mapping of keys") from None
    except yaml.MarkedYAMLError as error:
        raise InputError(f"{path}: is not valid YAML{yaml_mistake(read_written(path), error)}") from None
    except (ValueError, yaml.YAMLError) as error:  # a control character, a date that does not exist
        raise InputError(f"{path}: is not valid YAML: {' '.join(str(error).split())}") from None
    if not isinstance(data, dict):
        raise InputError(f"{path}: holds {kind_of(data)}, expected a mapping of keys")
    return data


def _check_size(path: Path, node: yaml.Node) -> None:
    size = _size(path, node, {})
    if size > LARGEST:
        raise InputError(f"{path}: its aliases stand for {size:.2g} values, expected at most {LARGEST}")


def _size(path: Path, node: yaml.Node, known: dict[int, int]) -> int:
    """How many values a node stands for when its aliases are written out."""
    if id(node) not in known:
        known[id(node)] = 0  # seen again before it is counted: it holds itself
        children = [part for item in node.value for part in (item if isinstance(item, tuple) else (item,))]
        parts = [] if isinstance(node, yaml.ScalarNode) else children
        known[id(node)] = 1 + sum(_size(path, part, known) for part in parts)
    elif known[id(node)] == 0:
        raise InputError(f"{path}: line {node.start_mark.line + 1}: a value holds itself, expected a tree of values")
    return known[id(node)]
