"""A MJCF file as MuJoCo compiles it; pictures and meshes that only dress a body are no reason to refuse it."""

import importlib.util
import warnings
from pathlib import Path
from typing import Any

from realitygap_engines.errors import ModelError


def compile_mjcf(path: Path) -> Any:
    """The `mujoco.MjModel` of a MJCF file, with all that the file itself says about its compilation.

    Raises:
        ModelError: for a file that MuJoCo cannot read, or where MuJoCo is not installed.
    """
    if importlib.util.find_spec("mujoco") is None:
        raise ModelError(f"{path}: is a MJCF file, which MuJoCo reads; install it with: pip install mujoco")
    import mujoco

    with warnings.catch_warnings():  # of settings that a later MuJoCo will not have: the file's authors are told by it
        warnings.simplefilter("ignore")
        return _compiled(path, mujoco)


def _compiled(path: Path, mujoco: Any) -> Any:
    try:
        try:
            return mujoco.MjSpec.from_file(str(path)).compile()
        except ValueError as error:
            if "file" not in str(error).lower():
                raise
            spec = mujoco.MjSpec.from_file(str(path))
            _undress(spec)
            return spec.compile()
    except (ValueError, RuntimeError) as error:
        what = " ".join(str(error).split()).removeprefix("Error: ")
        raise ModelError(f"{path}: is not a MJCF file that MuJoCo takes ({what})") from None


def _undress(spec: Any) -> None:
    """Without materials, textures and meshes that neither touch nor weigh anything."""
    for dressed in (*spec.geoms, *spec.sites):
        dressed.material = ""
    for geom in spec.geoms:
        touches = geom.contype or geom.conaffinity
        if geom.meshname and not touches and geom.parent.explicitinertial:
            spec.delete(geom)
    used = {geom.meshname for geom in spec.geoms if geom.meshname}
    for unused in (*spec.skins, *spec.materials, *spec.textures, *(x for x in spec.meshes if x.name not in used)):
        spec.delete(unused)
