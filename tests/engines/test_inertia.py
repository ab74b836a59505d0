"""What a moving link must weigh: inertia that no engine can turn is one sentence, and rounding is mended alike."""

from pathlib import Path

import numpy as np
import pytest
import realitygap_engines as engines
from realitygap.cli.main import main
from realitygap_engines import Physics, State
from realitygap_engines.errors import ModelError
from realitygap_engines.model.robot import Model
from realitygap_engines.model.urdf import read_urdf

DEMO = Path(__file__).parents[2] / "scenarios" / "demo"


def arm(folder: Path, moments: tuple[float, float, float], *, moving: bool = True) -> Path:
    """A pendulum whose bob (or whose base) has these moments of inertia."""
    odd = "".join(f' {k}="{v!r}"' for k, v in zip(("ixx", "iyy", "izz"), moments, strict=True))
    plain = ' ixx="1e-3" iyy="1e-3" izz="1e-3"'

    def link(name: str, tensor: str) -> str:
        place = '<origin xyz="0 0 -0.2"/>' if name == "bob" else ""
        tensor += ' ixy="0" ixz="0" iyz="0"'
        return f'<link name="{name}"><inertial>{place}<mass value="0.5"/><inertia{tensor}/></inertial></link>'

    path = folder / "arm.urdf"
    path.write_text(
        f'<robot name="r">{link("base", plain if moving else odd)}{link("bob", odd if moving else plain)}'
        '<joint name="hinge" type="continuous"><parent link="base"/><child link="bob"/><axis xyz="0 1 0"/></joint>'
        "</robot>"
    )
    return path


@pytest.mark.parametrize("moments", [(0.0, 0.0, 0.0), (1e-3, 1e-3, 0.0), (1e-3, 1e-3, 1e-16), (1e-17,) * 3])
def test_a_moving_link_without_inertia_is_one_sentence(moments: tuple[float, float, float], tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r"link bob moves but has principal moments of inertia .* expected all three"):
        read_urdf(arm(tmp_path, moments), floating=False)
    fixed = arm(tmp_path, moments, moving=False)
    assert read_urdf(fixed, floating=False).joint_names == ["hinge"]  # what is bolted down needs none
    with pytest.raises(ModelError, match="link base moves but"):
        read_urdf(fixed, floating=True)


def test_what_is_fixed_to_a_link_may_be_a_point(tmp_path: Path) -> None:
    """A frame with a little mass and no inertia is part of the link that carries it."""
    path = arm(tmp_path, (1e-3, 1e-3, 1e-3))
    point = '<inertial><mass value="1e-9"/><inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial>'
    path.write_text(
        path.read_text().replace(
            "</robot>",
            f'<link name="tip">{point}</link>'
            '<joint name="f" type="fixed"><parent link="bob"/><child link="tip"/></joint>'
            "</robot>",
        )
    )
    assert read_urdf(path, floating=False).mass == pytest.approx(1.0)


@pytest.mark.parametrize("engine", engines.available())
@pytest.mark.parametrize("moments", [(1e-3, 0.5e-3, 0.5e-3), (1e-3, 0.5e-3, 0.4991e-3)], ids=["a plate", "rounded"])
def test_a_plate_swings_alike_in_every_engine(moments: tuple[float, float, float], engine: str, tmp_path: Path) -> None:
    """Moments at the triangle rule, and short of it by what three digits leave out, are one machine everywhere."""
    model = read_urdf(arm(tmp_path, moments), floating=False)
    assert bool(model.notes) == (sum(moments[1:]) < moments[0])
    inertia = model.links[1].inertia[1, 1] + 0.5 * 0.2**2
    assert first_speed(model, engine) == pytest.approx(-0.5 * 9.81 * 0.2 / inertia * 1e-3, rel=1e-4)


def first_speed(model: Model, engine: str) -> float:
    with engines.load(engine).open(model, Physics(1e-3)) as simulation:
        simulation.reset(State(np.array([np.pi / 2]), np.zeros(1)))
        simulation.step(np.zeros(1), np.zeros(1), np.zeros(1))
        position, velocity = np.zeros(1), np.zeros(1)
        simulation.read(position, velocity, np.zeros(13))
    return float(velocity[0])


@pytest.mark.parametrize("command", ["run", "audit", "init"])
def test_every_command_says_it(command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    urdf = arm(tmp_path, (0.0, 0.0, 0.0))
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text(
        f"name: x\nrobot: {{urdf: arm.urdf, base: fixed, start: zero}}\nservos: []\nmotion: {{recorded: /c}}\n"
        f"recordings: {{state: /s, runs: [{{path: {DEMO / 'chirp_1.mcap'}}}]}}\n"
    )
    arguments = {
        "run": ["run", str(scenario), "--out", str(tmp_path / "out")],
        "audit": ["audit", str(urdf)],
        "init": ["init", str(urdf), str(DEMO / "chirp_1.mcap"), "--out", str(tmp_path / "new")],
    }
    with pytest.raises(SystemExit) as status:
        main(arguments[command])
    assert status.value.code == 2
    said = capsys.readouterr().err
    assert "link bob moves but has principal moments of inertia 0, 0, 0 kg·m²" in said
    assert said.count("\n") == 1
