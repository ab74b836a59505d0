"""The cache of compiled functions sees what numba's own does not: a change in another file."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

CALLER = """
from realitygap_engines.law.compiled import compiled
from callee import g

@compiled
def f(x):
    '''Doc.'''
    return g(x) + 1.0
"""
CALLEE = """
from realitygap_engines.law.compiled import compiled
FACTOR = {factor}

@compiled
def g(x):
    return {formula}
"""


@pytest.mark.parametrize(("formula", "expected"), [("FACTOR * x", "9.0"), ("3.0 * x + FACTOR", "11.0")])
def test_a_change_in_a_called_function_or_its_constants_is_seen(tmp_path: Path, formula: str, expected: str) -> None:
    def run(factor: float, formula: str) -> list[str]:
        (tmp_path / "callee.py").write_text(CALLEE.format(factor=factor, formula=formula))
        code = "import caller; print(caller.f(2.0), sum(caller.f.stats.cache_hits.values()), caller.f.__doc__)"
        out = subprocess.run(
            [sys.executable, "-B", "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True, env=os.environ
        )
        return out.stdout.split()

    (tmp_path / "caller.py").write_text(CALLER)
    assert run(2.0, "FACTOR * x") == ["5.0", "0", "Doc."]
    assert run(2.0, "FACTOR * x") == ["5.0", "1", "Doc."], "unchanged, it comes from the cache"
    assert run(4.0, formula) == [expected, "0", "Doc."]
