"""Expanding a xacro file where the package `xacro` is installed."""

import importlib.util
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from realitygap_engines.errors import ModelError

COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)


def is_xacro(path: Path, text: bytes) -> bool:
    """Whether a file has macros or expressions in it, whatever it is called.

    The namespace alone makes none: an expanded file may keep it.
    """
    if path.suffix == ".xacro" or b"<xacro:" in text:
        return True
    return b"xmlns:xacro" in text and any(sign in COMMENT.sub(b"", text) for sign in (b"${", b"$("))


def urdf_source(path: Path, packages: Mapping[str, Path]) -> str:
    """The text of a URDF file, expanded where it is a xacro. Errors as of `expanded`."""
    text = path.read_bytes()
    return (expanded(path, packages) if is_xacro(path, text) else text).decode("utf-8")


def expanded(path: Path, packages: Mapping[str, Path]) -> bytes:
    """The URDF of a xacro file, with the defaults of its arguments.

    `$(find NAME)` is looked for in `packages`, then beside and above the file, then where ROS has it.

    Raises:
        ModelError: where xacro is not installed, or cannot expand the file.
    """
    name = path.stem.removesuffix(".urdf") + (".urdf" if path.suffix == ".xacro" else "_expanded.urdf")
    by_hand = f"expand it first: xacro {path.name} > {name}"
    if importlib.util.find_spec("xacro") is None:
        raise ModelError(f"{path}: is a xacro file, not a URDF; {by_hand} (or: pip install xacro)")
    import xacro

    def folder(name: str) -> str:
        places = [packages[name]] if name in packages else [above / name for above in path.resolve().parents]
        for place in places:
            if place.is_dir():
                return str(place)
        if importlib.util.find_spec("ament_index_python") is None:
            raise ModelError(
                f"{path}: package {name} was not found; say where it lies: a scenario does under robot: packages:, "
                "and `init`, which writes a first one, takes --package NAME=DIR"
            )
        from ament_index_python.packages import get_package_share_directory

        return str(get_package_share_directory(name))

    try:
        with _finding(folder):
            return bytes(xacro.process_file(str(path)).toxml(encoding="utf-8"))
    except Exception as error:  # xacro raises what its expressions raise, too
        if isinstance(within := getattr(error, "exc", None), ModelError):
            raise within from None
        what = " ".join(str(error).split()) or type(error).__name__
        raise ModelError(f"{path}: is a xacro file that cannot be expanded ({what}); {by_hand}") from None


@contextmanager
def _finding(folder: Callable[[str], str]) -> Iterator[None]:
    """xacro asks ROS where packages lie, also where there is none: here it asks `folder`."""
    from xacro import substitution_args

    asked = substitution_args._eval_find
    substitution_args._eval_find = folder
    try:
        yield
    finally:
        substitution_args._eval_find = asked
