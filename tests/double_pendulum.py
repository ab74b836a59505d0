"""A pendulum on a pendulum that is let go, worked out from its closed form: synthetic, and of no engine.

It forgets how it began: repetitions that start within their sensor's noise are soon as far apart as they swing.
"""

from pathlib import Path

import numpy as np
import pandas as pd
from realitygap_engines import GRAVITY
from scipy.integrate import solve_ivp

MASSES, LENGTHS, INERTIA = (0.5, 0.4), (0.3, 0.25), 1e-3
"""Of the two links [kg, m]; their centres lie at their ends, about which their inertia is this [kg·m²]."""
FRICTION = 0.004
"""Viscous friction of the elbow [N·m·s/rad], which the scenario does not know."""
STARTS = {"first": (2.0, 1.4), "second": (-2.4, -0.7)}
"""Where the shoulder and the elbow are let go [rad], by motion."""
NOISE = 1e-3
"""Of the encoders [rad]."""
URDF = """<robot name="double">
<link name="base"/>
{links}
<joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/></joint>
<joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/><axis xyz="0 1 0"/>
<origin xyz="0 0 -{reach}"/></joint>
</robot>"""
LINK = """<link name="{name}"><inertial><origin xyz="0 0 -{length}"/><mass value="{mass}"/>
<inertia ixx="{inertia}" iyy="{inertia}" izz="{inertia}" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
SCENARIO = """
name: double_pendulum
robot: {urdf: double.urdf, base: fixed}
servos: [{joints: "*", kind: pid, kp: 1.0, kd: 0.0}]
motion: {recorded: command}
physics: {step_rate: 1000}
recordings:
  runs:
    - {path: "first_*.csv", use: train}
    - {path: "second_*.csv", use: held_out}
"""


def acceleration(q: np.ndarray, w: np.ndarray, friction: float) -> np.ndarray:
    """Of both joints [rad/s²]: the equations of motion of two links in a plane, hanging down at 0."""
    (m1, m2), (l1, l2) = MASSES, LENGTHS
    near, far = np.cos(q[1]), np.sin(q[1])
    coupling = INERTIA + m2 * (l2**2 + l1 * l2 * near)
    outer = INERTIA + m2 * l2**2
    inner = 2 * INERTIA + m1 * l1**2 + m2 * (l1**2 + l2**2 + 2 * l1 * l2 * near)
    swirl = m2 * l1 * l2 * far
    heavy = m2 * GRAVITY * l2 * np.sin(q[0] + q[1])
    force = np.array(
        [
            swirl * (2 * w[0] * w[1] + w[1] ** 2) - (m1 + m2) * GRAVITY * l1 * np.sin(q[0]) - heavy,
            -swirl * w[0] ** 2 - heavy - friction * w[1],
        ]
    )
    return np.linalg.solve(np.array([[inner, coupling], [coupling, outer]]), force)


def swung(time: np.ndarray, start: np.ndarray, friction: float) -> np.ndarray:
    """The angles over time, let go at rest. Shape (t, 2)."""
    found = solve_ivp(
        lambda _, x: np.concatenate([x[2:], acceleration(x[:2], x[2:], friction)]),
        (time[0], time[-1]),
        np.concatenate([start, np.zeros(2)]),
        t_eval=time,
        rtol=1e-9,
        atol=1e-10,
    )
    return np.asarray(found.y[:2].T)


def write_double(folder: Path, *, high: float = 1.0, lasts: float = 5.0) -> Path:
    """Three repetitions of two swings, let go at a share of `STARTS`, and a scenario without friction: its path."""
    links = zip(("upper", "lower"), MASSES, LENGTHS, strict=True)
    told = "\n".join(LINK.format(name=n, mass=m, length=x, inertia=INERTIA) for n, m, x in links)
    (folder / "double.urdf").write_text(URDF.format(links=told, reach=LENGTHS[0]))
    rng = np.random.default_rng(2)
    time = np.arange(0.0, lasts, 1 / 200)
    for name, start in STARTS.items():
        for k in range(3):
            begun = high * np.array(start) + NOISE * rng.standard_normal(2)
            angle = swung(time, begun, FRICTION) + NOISE * rng.standard_normal((len(time), 2))
            table = pd.DataFrame({"time": time, "position_shoulder": angle[:, 0], "position_elbow": angle[:, 1]})
            for joint in ("shoulder", "elbow"):  # servos that are off tell which runs repeat a motion
                table[f"command_{joint}"], table[f"torque_enabled_{joint}"] = 0.0, 0
            table.to_csv(folder / f"{name}_{k}.csv", index=False)
    path = folder / "scenario.yaml"
    path.write_text(SCENARIO)
    return path
