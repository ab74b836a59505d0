"""A URDF with measured masses and centres of mass: what changes in every link, and the edited file."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
from realitygap_engines.model.inertia import Inertial
from realitygap_engines.model.inertial_editor import with_inertials
from realitygap_engines.model.robot import rotation_from_rpy

from realitygap.bench.estimate import Array
from realitygap.bench.link_file import LinkBench, Part
from realitygap.bench.plausible import body, doubts
from realitygap.bench.table import read_table
from realitygap.bench.urdf_links import UrdfFile, UrdfLink
from realitygap.files.errors import InputError
from realitygap.scenario.file import resolve_path


@dataclass(frozen=True)
class Measured:
    """What was measured of one URDF link: `mass` [kg] and `com` (3,) [m] in the link's frame, None where it was not."""

    part: str
    mass: float | None = None
    com: Array | None = None


def read_tables(path: Path, bench: LinkBench) -> tuple[pd.DataFrame | None, pd.DataFrame | None]:
    """The tables of masses and of centres of mass, in SI units, indexed by part."""
    masses = centers = None
    if bench.masses:
        file = resolve_path(path, bench.masses.table, "masses.table")
        masses = _by_part(file, read_table(file, ("link",), {"mass": bench.masses.unit}))
        wrong = masses[masses["mass"] <= 0]
        if len(wrong):
            raise InputError(f"{file}: {wrong.index[0]} weighs {wrong['mass'].iloc[0]:g} kg, expected more than 0")
    if bench.centers:
        file = resolve_path(path, bench.centers.table, "centers.table")
        axes = ("x", "y", "z")
        columns = dict.fromkeys([*axes, *(f"cad_{a}" for a in axes)], bench.centers.unit)
        centers = _by_part(file, read_table(file, ("link",), columns, optional=[f"cad_{a}" for a in axes]))
        if bench.centers.use == "cad" and not {"cad_x", "cad_y", "cad_z"} <= set(centers.columns):
            raise InputError(f"{path}: centers.use: is cad, but {file.name} lacks cad_x, cad_y or cad_z")
    return masses, centers


def _by_part(file: Path, table: pd.DataFrame) -> pd.DataFrame:
    double = table["link"][table["link"].duplicated()]
    if len(double):
        raise InputError(f"{file}: two links under one name: {double.iloc[0]} stands twice; expected every link once")
    return table.set_index("link")


def measurements(path: Path, bench: LinkBench, urdf: UrdfFile) -> dict[str, Measured]:
    """What was measured, by URDF link; the mirror image of a pair has the mirrored centre of mass."""
    masses, centers = read_tables(path, bench)
    parts = {p.name: p for p in bench.parts}
    names = [*(masses.index if masses is not None else []), *(centers.index if centers is not None else [])]
    weights = masses["mass"].to_dict() if masses is not None else {}
    prefix = "cad_" if bench.centers and bench.centers.use == "cad" else ""
    out: dict[str, Measured] = {}
    for name in dict.fromkeys(str(n) for n in names):
        part = parts.get(name) or Part(name=name, links=[name])
        mass = float(weights[name]) if name in weights else None
        com = None
        if centers is not None and name in centers.index:
            com = centers.loc[name, [f"{prefix}{a}" for a in "xyz"]].to_numpy(float)
            if part.rotation is not None:
                com = rotation_from_rpy(*(np.array(part.rotation.rpy) * part.rotation.unit)) @ com
        for i, link in enumerate(part.links):
            if link not in urdf.links:
                raise InputError(
                    f"{path}: part {name}: {urdf.path.name} has no link {link} with an <inertial>; found "
                    f"{', '.join(urdf.links)} (name a part's links under parts)"
                )
            side = np.array([1.0, -1.0 if i else 1.0, 1.0])
            out[link] = Measured(name, mass, None if com is None else com * side)
    return out


def revised(link: UrdfLink, measured: Measured) -> tuple[UrdfLink, str]:
    """The link with what was measured, and what was done to its inertia tensor, in words.

    The tensor was not measured. Where nothing is wrong with it, it grows with the mass (same shape); where it is
    impossible or implausible, it becomes that of a body of uniform density that fills the collision geometry.
    """
    mass = link.mass if measured.mass is None else measured.mass
    com = link.com if measured.com is None else measured.com
    form = body(link.points)
    if form is not None and any(d.tensor for d in doubts(link)):
        return replace(link, mass=mass, com=com, inertia=form.solid * mass), "uniform body of the geometry"
    return replace(link, mass=mass, com=com, inertia=link.inertia * (mass / link.mass)), "scaled with the mass"


def revised_text(urdf: UrdfFile, links: dict[str, UrdfLink]) -> str:
    """The text of the URDF with these links' inertials, which were measured to six digits at most."""
    bodies: dict[str, Inertial | None] = {name: (k.mass, k.com, k.inertia) for name, k in links.items()}
    return with_inertials(urdf.text, bodies, digits=6).written()
