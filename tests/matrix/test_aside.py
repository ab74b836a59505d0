"""Recordings that are laid aside are read as they were, by whoever needs them, and are gone at the end."""

import pickle
from pathlib import Path

import numpy as np
import pytest
from realitygap.matrix import aside
from realitygap.matrix.matrix_file import matrix_of
from realitygap.matrix.plan import plan
from realitygap.scenario.file import load_scenario
from signals import Signals, there

DEMO = Path(__file__).parents[2] / "scenarios" / "demo" / "scenario.yaml"


def test_a_task_is_small_and_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tasks = plan(matrix_of(load_scenario(DEMO), ["mujoco"]))
    monkeypatch.setattr(aside, "LARGE", 1000)
    with aside.laid_aside(tasks, tmp_path) as laid:
        for before, after in zip(tasks, laid.tasks, strict=True):
            assert len(laid.pickled(before)) < len(pickle.dumps(before)) / 5
            whole, laid_aside = (Signals(there(task.motion.measured)).position for task in (before, after))
            np.testing.assert_array_equal(laid_aside, whole)
            assert not laid_aside.flags.writeable
        files = [p.stat().st_size for p in tmp_path.rglob("*.npy")]
        assert sum(files) < 2 * sum(len(pickle.dumps(t)) for t in tasks)  # what cells share lies there once
    assert not list(tmp_path.iterdir())
