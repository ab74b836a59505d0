"""A robot keeps its feet: the centre of pressure against its closed form, and soles that tip against engines."""

import numpy as np
import pytest
import realitygap_engines as engines
from realitygap.robot.drive import Array
from realitygap.simulate.footing import EDGE, MOVED, beyond, footing_of, lost_footing
from realitygap.trace.trace import Trace
from realitygap_engines import GRAVITY, Ground, Physics, State
from realitygap_engines.model.read import read_model
from realitygap_engines.model.robot import Model

LONG, WIDE, HIGH = 0.24, 0.16, 0.04
MASS, CARRIED, UP, INERTIA = 1.5, 2.0, 0.3, 0.02
URDF = f"""<robot name="stander">
<link name="foot"><inertial><origin xyz="0 0 0"/><mass value="{MASS}"/>
<inertia ixx="0.004" ixy="0" ixz="0" iyy="0.008" iyz="0" izz="0.01"/></inertial>
<collision><geometry><box size="{LONG} {WIDE} {HIGH}"/></geometry></collision></link>
<link name="pole"><inertial><origin xyz="0 0 {UP}"/><mass value="{CARRIED}"/>
<inertia ixx="{INERTIA}" ixy="0" ixz="0" iyy="{INERTIA}" iyz="0" izz="0.002"/></inertial></link>
<joint name="ankle" type="revolute"><parent link="foot"/><child link="pole"/><axis xyz="0 1 0"/>
<limit lower="-1.5" upper="1.5" effort="40" velocity="8"/></joint></robot>"""


@pytest.fixture(scope="module")
def stander(tmp_path_factory: pytest.TempPathFactory) -> Model:
    """A pole on a foot."""
    path = tmp_path_factory.mktemp("stander") / "robot.urdf"
    path.write_text(URDF, encoding="utf-8")
    return read_model(path, floating=True)


def traced(time: Array, angle: Array, base: Array | None = None) -> Trace:
    """A motion of the pole; the foot is where `base` (t, 3) says, flat on the ground without it."""
    place = np.tile([0.3, -0.1, HIGH / 2], (len(time), 1)) if base is None else base
    return Trace(
        time,
        ("ankle",),
        angle[:, None],
        np.gradient(angle, time)[:, None],
        base_position=place,
        base_quaternion=np.tile([1.0, 0.0, 0.0, 0.0], (len(time), 1)),
    )


@pytest.mark.parametrize("faster", [0.0, 1.0, 3.0, 9.0])
def test_the_centre_of_pressure_is_that_of_the_closed_form(stander: Model, faster: float) -> None:
    time = np.arange(0.0, 2.0, 0.001)
    size = 0.15
    q = size * np.cos(faster * time)
    footing = footing_of(stander, traced(time, q))
    a = size * np.cos(faster * footing.time)
    da, dda = -faster * size * np.sin(faster * footing.time), -(faster**2) * a
    x, z = UP * np.sin(a), UP * np.cos(a)
    ddx, ddz = UP * (dda * np.cos(a) - da**2 * np.sin(a)), -UP * (dda * np.sin(a) + da**2 * np.cos(a))
    weight = (MASS + CARRIED) * GRAVITY + CARRIED * ddz
    moment = CARRIED * ((z + HIGH / 2) * ddx - x * (GRAVITY + ddz)) + INERTIA * dda
    inside = slice(1, -1)
    assert footing.pressure[inside, 0] == pytest.approx((0.3 - moment / weight)[inside], abs=3e-4)
    assert footing.pressure[inside, 1] == pytest.approx(-0.1, abs=1e-9)


def test_feet_are_lost_where_the_pressure_comes_near_an_edge_or_the_sole_moves(stander: Model) -> None:
    time = np.arange(0.0, 1.0, 0.002)
    most = np.arcsin((MASS + CARRIED) * (1 - EDGE) * LONG / 2 / (CARRIED * UP))  # a lean that is held
    assert len(lost_footing(stander, traced(time, np.full(len(time), 0.98 * most)))) == 0
    assert len(lost_footing(stander, traced(time, np.full(len(time), 1.02 * most)))) == len(time[::5])
    place = np.tile([0.0, 0.0, HIGH / 2], (len(time), 1))
    for share, lost in ((0.9, False), (1.1, True)):
        slid = place + np.outer(time / time[-1], [0.6 * share * MOVED, 0.8 * share * MOVED, 0.0])
        assert bool(len(lost_footing(stander, traced(time, np.zeros(len(time)), slid)))) is lost


def test_what_stands_on_no_sole_keeps_none(stander: Model) -> None:
    time = np.arange(0.0, 0.5, 0.002)
    air = np.tile([0.0, 0.0, 1.0], (len(time), 1))
    assert np.all(beyond(footing_of(stander, traced(time, np.zeros(len(time)), air))) > 0.0)


@pytest.mark.parametrize("engine", engines.available())
def test_a_foot_tips_in_every_engine_where_the_pressure_says_so(stander: Model, engine: str) -> None:
    """A pole that is held leaning stands as long as its weight is over the sole."""
    edge = float(np.arcsin((MASS + CARRIED) * LONG / 2 / (CARRIED * UP)))
    physics = Physics(1e-3, 50, Ground(0.8))
    for lean, stands in ((0.8 * edge, True), (1.15 * edge, False)):
        try:
            simulation = engines.load(engine).open(stander, physics)
        except engines.Unsupported as error:
            pytest.skip(str(error))
        state = State(np.array([lean]), np.zeros(1))
        state.base_position = np.array([0.0, 0.0, HIGH / 2])
        simulation.reset(state)
        q, w, base = np.zeros((1001, 1)), np.zeros((1001, 1)), np.zeros((1001, 13))
        for k in range(1001):
            simulation.read(q[k], w[k], base[k])
            held = np.array([400.0 * (lean - q[k, 0]) - 10.0 * w[k, 0]])
            simulation.step(held, np.zeros(1), np.zeros(1))
        simulation.close()
        time = np.arange(0.0, 1.0005, 1e-3)
        trace = Trace(time, ("ankle",), q, w, base_position=base[:, :3], base_quaternion=base[:, 3:7])
        assert (len(lost_footing(stander, trace.between(0.1, 1.0))) == 0) is stands
