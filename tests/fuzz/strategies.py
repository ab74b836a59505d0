"""What people, programs and disks do to files: values that no robot has, bits that flip, files that are cut off."""

import copy
import math
from typing import Any

from hypothesis import strategies as st

WORDS = [
    "", " ", "a\nb", "\x00", "\x1b[31m", r"a$\frac{$b", "=1+1", "x" * 5000, "../..", "/dev/zero", "/proc/self/mem",
    "${HOME}", "${NOPE}", "*", "[", "é💥\u202e", "elbow", "none", "nan", "1e400", "</script><b>", "arm.urdf", "run.csv",
    "\ud800",
]  # fmt: skip
NUMBERS = [0, -1, 1, 2, 1e-300, 5e-324, 1e6, 1e9, 1e200, 1e300, -1e300, math.inf, -math.inf, math.nan, 2**63, 10**400]
words = st.sampled_from(WORDS) | st.text(max_size=20)
numbers = st.sampled_from(NUMBERS) | st.floats() | st.integers()
values = st.recursive(
    st.none() | st.booleans() | numbers | words,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(words, inner, max_size=3),
    max_leaves=5,
)


def places(tree: Any, way: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Where something stands in nested lists and mappings."""
    out = [way] if way else []
    pairs = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for key, value in pairs:
        out += places(value, (*way, key))
    return out


@st.composite
def altered(draw: st.DrawFn, tree: Any) -> Any:
    """Nested lists and mappings with up to three things changed, taken away, doubled or added."""
    tree = copy.deepcopy(tree)
    for _ in range(draw(st.integers(1, 3))):
        ways = places(tree)
        if not ways:
            break
        *way, last = draw(st.sampled_from(ways))
        node = tree
        for part in way:
            node = node[part]
        what = draw(st.sampled_from(["replace", "replace", "replace", "delete", "double", "add"]))
        if what == "replace":
            node[last] = draw(values)
        elif what == "delete":
            del node[last]
        elif isinstance(node, list):
            node.insert(last, copy.deepcopy(node[last]) if what == "double" else draw(values))
        elif what == "add":
            node[draw(words)] = draw(values)
    return tree


@st.composite
def damaged(draw: st.DrawFn, data: bytes) -> bytes:
    """Bytes that were cut off, flipped, overwritten, doubled or put in."""
    out = bytearray(data)
    for _ in range(draw(st.integers(1, 3))):
        at = draw(st.integers(0, max(len(out) - 1, 0)))
        what = draw(st.sampled_from(["cut", "flip", "flip", "zero", "double", "insert", "number"]))
        size = draw(st.integers(1, 64))
        if what == "cut":
            del out[len(out) * draw(st.integers(0, 50)) // 50 :]
        elif what == "flip" and out:
            out[at] ^= 1 << draw(st.integers(0, 7))
        elif what == "zero":
            out[at : at + size] = bytes([draw(st.sampled_from([0, 255]))]) * len(out[at : at + size])
        elif what == "double":
            out[at:at] = out[at : at + size]
        elif what == "insert":
            out[at:at] = draw(words).encode("utf-8", "surrogatepass")
        elif what == "number":
            out[at:at] = repr(draw(numbers)).encode()
    return bytes(out)
