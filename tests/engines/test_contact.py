"""Contact spheres touch the ground where the shapes themselves would."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
from realitygap_engines.errors import ModelError
from realitygap_engines.model.contact import MANY
from realitygap_engines.model.robot import Model, axis_rotation, lowest_point
from realitygap_engines.model.urdf import read_urdf

INERTIAL = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
SHAPES = {
    "sphere": '<sphere radius="0.3"/>',
    "box": '<box size="0.2 0.4 0.6"/>',
    "cylinder": '<cylinder radius="0.2" length="0.5"/>',
    "mesh": '<mesh filename="box.stl" scale="2 2 2"/>',
    "package": '<mesh filename="package://robot/box.stl" scale="2 2 2"/>',
}


def body(folder: Path, geometry: str, origin: str = "") -> Model:
    trimesh.creation.box((0.1, 0.2, 0.3)).export(folder / "box.stl")
    path = folder / "robot.urdf"
    path.write_text(
        f'<robot name="r"><link name="base">{INERTIAL}<collision>{origin}<geometry>{geometry}</geometry></collision>'
        "</link></robot>"
    )
    return read_urdf(path, floating=True, packages={"robot": folder})


def height(model: Model, rotation: np.ndarray | None = None) -> float:
    pose = np.eye(4)
    pose[:3, :3] = np.eye(3) if rotation is None else rotation
    return -lowest_point(model, pose[None])


@pytest.mark.parametrize(
    ("shape", "down"),
    [("sphere", 0.3), ("box", 0.3), ("cylinder", 0.25), ("mesh", 0.3), ("package", 0.3)],
)
def test_lowest_point_is_that_of_the_shape(shape: str, down: float, tmp_path: Path) -> None:
    """To the inset of a mesh's corner spheres, whose centres go towards the middle rather than off each face."""
    within = 1e-3 if shape in ("mesh", "package") else 1e-12
    assert height(body(tmp_path, SHAPES[shape])) == pytest.approx(down, abs=within)
    origin = '<origin xyz="0 0 -0.1" rpy="0 1.5707963267948966 0"/>'
    on_side = {"sphere": 0.3, "cylinder": 0.2}.get(shape, 0.1)
    assert height(body(tmp_path, SHAPES[shape], origin)) == pytest.approx(0.1 + on_side, abs=max(within, 1e-9))


@pytest.mark.parametrize("seed", range(5))
def test_a_box_in_any_attitude_rests_on_its_corner(seed: int, tmp_path: Path) -> None:
    """Rounded by the corner spheres: a corner is at most (√3 - 1)·1 mm lower than the sphere in it."""
    random = np.random.default_rng(seed)
    axis = random.standard_normal(3)
    rotation = axis_rotation(axis / np.linalg.norm(axis), random.uniform(0, np.pi))
    corners = np.array(np.meshgrid(*[(-h, h) for h in (0.1, 0.2, 0.3)])).reshape(3, -1)
    exact = -(rotation @ corners)[2].min()
    assert exact - 7.4e-4 <= height(body(tmp_path, SHAPES["box"]), rotation) <= exact + 1e-12


def test_few_spheres_stand_for_a_fine_mesh(tmp_path: Path) -> None:
    ball = trimesh.creation.icosphere(subdivisions=3)
    ball.apply_scale((0.1, 0.06, 0.02))
    ball.export(tmp_path / "ball.stl")
    model = body(tmp_path, '<mesh filename="ball.stl"/>')
    assert 4 <= len(model.links[0].spheres) <= MANY


def test_a_flat_plate_touches_with_its_corners(tmp_path: Path) -> None:
    model = body(tmp_path, '<box size="0.1 0.1 0.0001"/>')
    points = np.array([s.center for s in model.links[0].spheres])
    assert {tuple(np.sign(p[:2])) for p in points} == {(-1, -1), (-1, 1), (1, -1), (1, 1)}


@pytest.mark.parametrize(
    ("content", "name", "sentence"),
    [
        (None, "none.stl", r"was not found; expected it at \S*none\.stl$"),
        (None, "package://elsewhere/box.stl", "say where a package lies under robot: packages:"),
        (b"", "empty.stl", "mesh .*empty.stl of link base"),
        (b"no mesh\n", "text.stl", "mesh .*text.stl of link base"),
        (b"no mesh\n", "text.obj", "mesh .*text.obj of link base"),
        (b"x", "mesh.xyz123", "cannot be read"),
    ],
)
def test_a_mesh_that_cannot_be_used(
    content: bytes | None, name: str, sentence: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(ModelError, match=sentence) as error:
        body(tmp_path, f'<mesh filename="{name}"/>')
    assert "\n" not in str(error.value)
    assert capfd.readouterr() == ("", "")
