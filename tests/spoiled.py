"""Edits that spoil a folder with the demo, and what the command line says to it."""

from collections.abc import Callable
from pathlib import Path

import pytest
import yaml
from realitygap.cli.main import main

DEMO = Path(__file__).parents[1] / "scenarios" / "demo"
Edit = Callable[[Path], None]


def changed(**keys: object) -> Edit:
    """The scenario with keys changed; `__` goes into a section or list."""

    def edit(folder: Path) -> None:
        path = folder / "scenario.yaml"
        data = yaml.safe_load(path.read_text())
        for key, value in keys.items():
            *way, last = (int(p) if p.isdigit() else p for p in key.split("__"))
            node = data
            for part in way:
                node = node[part]
            node[last] = value
        path.write_text(yaml.safe_dump(data))

    return edit


def file(name: str, content: str | bytes, **keys: object) -> Edit:
    """A file beside the scenario, and keys that use it."""

    def edit(folder: Path) -> None:
        (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())
        if keys:
            changed(**keys)(folder)

    return edit


def text(old: str, new: str, name: str = "arm.urdf") -> Edit:
    """Text replaced in a file."""

    def edit(folder: Path) -> None:
        before = (folder / name).read_text()
        assert old in before
        (folder / name).write_text(before.replace(old, new))

    return edit


def cut(name: str, share: float) -> Edit:
    def edit(folder: Path) -> None:
        data = (folder / name).read_bytes()
        (folder / name).write_bytes(data[: int(len(data) * share)])

    return edit


def folder_instead(name: str) -> Edit:
    def edit(folder: Path) -> None:
        (folder / name).unlink()
        (folder / name).mkdir()

    return edit


def gone(name: str) -> Edit:
    return lambda folder: (folder / name).unlink()


def refused(*arguments: str | Path) -> int:
    """The exit status of a command."""
    with pytest.raises(SystemExit) as end:
        main([str(a) for a in arguments])
    assert isinstance(end.value.code, int)
    return end.value.code


def one_sentence(captured: tuple[str, str]) -> str:
    """What went to standard error, which is all that was said."""
    out, err = captured
    assert out == ""
    assert err.startswith("realitygap: ")
    assert err.count("\n") == 1
    assert "Traceback" not in err
    return err
