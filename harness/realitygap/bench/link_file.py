"""The file of `realitygap bench links`: a URDF, and what was weighed and balanced."""

from pathlib import Path
from typing import Literal

from pydantic import Field

from realitygap.bench.quantity import AngleUnit, LengthUnit, MassUnit
from realitygap.files.errors import InputError
from realitygap.files.validation import validate
from realitygap.files.yaml_file import load_yaml
from realitygap.scenario.section import Finite, Section
from realitygap.scenario.which_file import check_kind


class MassTable(Section):
    """Measured masses: columns link, mass."""

    table: str = Field(description="a CSV or Parquet table with the columns link and mass")
    unit: MassUnit


class CenterTable(Section):
    """Centres of mass in the part's frame: columns link, x, y, z, and from a CAD model perhaps cad_x, cad_y, cad_z."""

    table: str = Field(description="a table with the columns link, x, y, z and perhaps cad_x, cad_y, cad_z")
    unit: LengthUnit
    use: Literal["measured", "cad"] = Field(default="measured", description="which of the two to write into the URDF")


class Rotation(Section):
    """Fixed-axis roll, pitch and yaw, as in a URDF."""

    rpy: tuple[Finite, Finite, Finite] = Field(description="roll, pitch, yaw")
    unit: AngleUnit


class Part(Section):
    """A measured part and the URDF links that it is."""

    name: str = Field(description="the part's name in the tables")
    links: list[str] = Field(
        min_length=1, max_length=2, description="its URDF link; for a pair the measured side and its mirror image"
    )
    rotation: Rotation | None = Field(default=None, description="of the part's frame in the (measured) link's frame")


class LinkBench(Section):
    """A link bench."""

    urdf: str = Field(description="the URDF file")
    packages: dict[str, str] = Field(default={}, description="where package://NAME/ lies")
    masses: MassTable | None = Field(default=None, description="measured masses")
    centers: CenterTable | None = Field(default=None, description="measured centres of mass")
    parts: list[Part] = Field(default=[], description="the measured parts, where they are not named as the links")
    mirror: list[tuple[str, str]] = Field(
        default=[("r_", "l_"), ("right_", "left_")], description="prefixes of mirror images (across the x-z plane)"
    )


def load_link_bench(path: Path) -> LinkBench:
    """The checked bench file.

    Raises:
        InputError: one sentence on the first thing that is wrong.
    """
    raw = load_yaml(path)
    check_kind(path, "a bench of links", raw)
    bench = validate(path, LinkBench, raw)
    links = [link for part in bench.parts for link in part.links]
    for what, names in (("name", [p.name for p in bench.parts]), ("links", links)):
        double = next((n for n in names if names.count(n) > 1), None)
        if double is not None:
            raise InputError(f"{path}: parts: {what}: {double} stands twice; expected every one once")
    return bench
