"""Arrays that are mapped from files."""

from pathlib import Path

import numpy as np
from realitygap.files.mapped import let_go, mapped


def resident() -> float:
    """Bytes of files that this process holds in memory."""
    status = Path("/proc/self/status").read_text()
    return 1024.0 * int(next(line.split()[1] for line in status.splitlines() if line.startswith("RssFile")))


def test_what_was_let_go_is_there_again_when_it_is_read(tmp_path: Path) -> None:
    value = np.random.default_rng(0).normal(size=(1 << 18, 20))
    np.save(tmp_path / "value.npy", value)
    found = mapped(tmp_path / "value.npy")
    before = resident()
    total = found.sum()
    held = resident()
    assert held - before > 0.9 * value.nbytes
    let_go(found[10:, :3])
    assert held - resident() > 0.9 * value.nbytes
    assert found.sum() == total
    np.testing.assert_array_equal(found, value)


def test_what_lies_in_memory_stays() -> None:
    own = np.arange(6.0).reshape(2, 3)
    fixed = own.copy()
    fixed.flags.writeable = False
    for value in (own, own[:1], fixed, fixed[1:], None):
        let_go(value)
    np.testing.assert_array_equal(own, fixed)
