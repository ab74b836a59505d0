"""The actuators of a MJCF file as servos, and sentences on what a servo cannot say of them.

MuJoCo's forces, for control u, actuator length l = gear·q and velocity gear·ω (its documentation, "Actuation model"):

- fixed gain and affine bias: gain·u + b0 + b1·l + b2·l'; `position` has b1 = −gain, `velocity` b2 = −gain, `motor`
  neither. Damping inside a `position` acts on the speed, not on the rate of the error: a `cascade` servo.
- `pid`: kp·(u − l) + ki·∫(u − l) + kv·(u' − l'): a `pid` servo.
- `dcmotor` told volts: K/R·(u − K·l'), a `dc` servo; told a goal, kp·(u − l) + ki·∫(u − l) + kd·(u' − l') as far as
  ±Vmax allows: a `pid` servo, with a torque-speed limit.

The force acts on the joint gear times.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from realitygap_engines.model.robot import Actuator

FIXED, AFFINE, DCMOTOR, PID = "mjGAIN_FIXED", "mjBIAS_AFFINE", "mjGAIN_DCMOTOR", "mjGAIN_PID"


@dataclass(frozen=True)
class Drives:
    """The actuators that became servos, the effort limit [N·m or N] of each driven joint, and what was lost."""

    actuators: tuple[Actuator, ...]
    limits: dict[str, float]
    notes: tuple[str, ...]


def read_actuators(m: Any, joints: dict[int, str]) -> Drives:
    """The servos of a compiled model (`mujoco.MjModel`), for the joints of the robot: MuJoCo's number -> name."""
    actuators: dict[str, Actuator] = {}
    limits: dict[str, float] = {}
    notes: list[str] = []
    for i in range(len(m.actuator_trnid)):
        name = f"actuator {m.actuator(i).name or i}"
        joint = joints.get(int(m.actuator_trnid[i, 0])) if _on_joint(m, i) else None
        if joint is None:
            notes.append(f"{name} is left out: it acts on no joint of the robot")
            continue
        if joint in actuators:
            notes.append(f"{name} is left out: joint {joint} is driven by another one already")
            continue
        found, lost = _servo(m, i, joint)
        notes += [f"{name} on joint {joint}: {sentence}" for sentence in lost]
        if found is not None:
            actuators[joint] = found
            limits[joint], unequal = _limit(m, i, found.kind)
            notes += [f"{name} on joint {joint}: {unequal}"] if unequal else []
    return Drives(tuple(actuators.values()), limits, tuple(notes))


def reflected(m: Any, field: str) -> dict[int, float]:
    """What actuators add to the `armature` or `damping` of joints, by MuJoCo's number of the joint."""
    own: Any = getattr(m, f"actuator_{field}", np.zeros(len(m.actuator_trnid)))  # MuJoCo 3.3 has neither
    out: dict[int, float] = {}
    for i in range(len(m.actuator_trnid)):
        if _on_joint(m, i):
            joint = int(m.actuator_trnid[i, 0])
            out[joint] = out.get(joint, 0.0) + float(own[i]) * float(m.actuator_gear[i, 0]) ** 2
    return out


def _on_joint(m: Any, i: int) -> bool:
    import mujoco

    kinds = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
    return int(m.actuator_trntype[i]) in [int(k) for k in kinds]


def _servo(m: Any, i: int, joint: str) -> tuple[Actuator | None, list[str]]:
    import mujoco

    gain_type = mujoco.mjtGain(m.actuator_gaintype[i]).name
    bias_type = mujoco.mjtBias(m.actuator_biastype[i]).name
    dynamics = mujoco.mjtDyn(m.actuator_dyntype[i]).name
    gear = float(m.actuator_gear[i, 0])
    if gain_type == DCMOTOR:
        return _dc(m, i, joint, gear)
    if gain_type == PID:
        return _pid(m, i, joint, gear)
    lost = []
    if dynamics in ("mjDYN_FILTER", "mjDYN_FILTEREXACT"):
        lost.append(f"its filter of {float(m.actuator_dynprm[i, 0]):g} s is left out")
    elif dynamics != "mjDYN_NONE":
        return None, [f"its dynamics {_said(dynamics)} are no servo, it is left out"]
    if gain_type != FIXED or bias_type not in ("mjBIAS_NONE", AFFINE):
        return None, [f"its gain {_said(gain_type)} and bias {_said(bias_type)} are no servo, it is left out"]
    affine, more = _affine(m, i, joint, gear, bias_type == AFFINE)
    return affine, lost + more


def _affine(m: Any, i: int, joint: str, gear: float, biased: bool) -> tuple[Actuator | None, list[str]]:
    gain = float(m.actuator_gainprm[i, 0])
    b0, b1, b2 = (float(b) for b in m.actuator_biasprm[i, :3]) if biased else (0.0, 0.0, 0.0)
    lost = [f"its constant force {b0 * gear:g} is left out (effect constant_effort says it)"] if b0 else []
    kp, kd = -b1 * gear * gear, -b2 * gear * gear
    if kp < 0 or kd < 0 or gain == 0:
        return None, ["it pushes away from its goal or has no gain, it is left out"]
    if kp > 0:
        if not np.isclose(gain, -b1):
            lost.append(f"its control counts {gain / -b1:g} times; the scenario's commands are joint positions")
        if kd == 0:
            return Actuator(joint, "pid", {"kp": kp}), lost
        return Actuator(joint, "cascade", {"gain": 1.0, "kv": kd, "kp": kp / kd}), lost
    if kd > 0:
        if not np.isclose(gain, -b2):
            lost.append(f"its control counts {gain / -b2:g} times; the scenario's commands are joint velocities")
        return Actuator(joint, "velocity", {"gain": kd}), [
            *lost,
            "it takes velocities: say `as: velocity` under `motion`",
        ]
    if not np.isclose(gain * gear, 1.0):
        lost.append(f"its control counts {gain * gear:g} times; the scenario's commands are efforts at the joint")
    return Actuator(joint, "effort", {}), [*lost, "it takes efforts: say `as: effort` under `motion`"]


def _pid(m: Any, i: int, joint: str, gear: float) -> tuple[Actuator | None, list[str]]:
    import mujoco

    square = gear * gear
    kp, kd = (-float(b) * square for b in m.actuator_biasprm[i, 1:3])
    ki, most, slew = float(m.actuator_gainprm[i, 0]) * square, float(m.actuator_dynprm[i, 0]), 0.0
    if m.actuator_dynprm.shape[1] > 1:
        slew = float(m.actuator_dynprm[i, 1])
    lost = [f"the limit {most:g} of its integral is left out"] if ki and most else []
    lost += [f"its slew limit {slew:g} is left out"] if slew else []
    told = int(m.actuator_ctrlspec[i])
    if kd and told and not told & int(mujoco.mjtCtrlInput.mjINPUT_VEL):  # damping acts on the speed alone
        if ki == 0:
            return Actuator(joint, "cascade", {"gain": 1.0, "kv": kd, "kp": kp / kd}), lost
        lost.append("its kv acts on the speed, and here on the rate of the error")
    return Actuator(joint, "pid", {"kp": kp, "ki": ki, "kd": kd}), lost


def _dc(m: Any, i: int, joint: str, gear: float) -> tuple[Actuator | None, list[str]]:
    import mujoco

    resistance, constant = float(m.actuator_gainprm[i, 0]), float(m.actuator_gainprm[i, 1]) * abs(gear)
    kp, ki, kd, most = (float(x) for x in m.actuator_gainprm[i, 4:8])
    dynamics, bias, square = m.actuator_dynprm[i], m.actuator_biasprm[i], gear * gear
    if not (resistance > 0 and constant > 0):
        return None, ["it has no resistance or no motor constant, it is left out"]
    lost = []
    if bias[0]:
        lost.append(
            f"its cogging is left out (effect torque_ripple: amplitude {bias[0] * abs(gear):g}, "
            f"periods {bias[1] * abs(gear):g}, phase {bias[2]:g})"
        )
    if dynamics[0]:
        lost.append(f"its inductance (time constant {dynamics[0]:g} s) is left out")
    if np.any(m.actuator_gainprm[i, 2:4]) or np.any(dynamics[1:7]) or np.any(bias[3:]):
        lost.append("its saturation, heat or LuGre friction is left out")
    if int(m.actuator_ctrlspec[i]) & int(mujoco.mjtCtrlInput.mjINPUT_VOLTAGE):
        ends = m.actuator_ctrlrange[i] if m.actuator_ctrllimited[i] else (0.0, 0.0)
        supply = float(max(abs(ends[0]), abs(ends[1]))) or 1.0
        values = {"gain": 0.0, "supply": supply, "torque_constant": constant, "resistance": resistance}
        return Actuator(joint, "dc", values), [
            *lost,
            f"it takes volts: say `as: duty` under `motion`, with duty 1 for {supply:g} V",
        ]
    if most > 0:
        lost.append(
            "its voltage limit is left out (effect torque_speed_limit: "
            f"stall_torque {constant * most / resistance:g}, no_load_speed {most / constant:g})"
        )
    return Actuator(joint, "pid", {"kp": kp * square, "ki": ki * square, "kd": kd * square}), lost


def _limit(m: Any, i: int, kind: str) -> tuple[float, str | None]:
    """The largest effort of an actuator at its joint, and a sentence where it differs by direction."""
    gear, ends = abs(float(m.actuator_gear[i, 0])), []
    if m.actuator_forcelimited[i]:
        ends.append(gear * m.actuator_forcerange[i])
    if kind == "effort" and m.actuator_ctrllimited[i]:
        ends.append(gear * abs(float(m.actuator_gainprm[i, 0])) * m.actuator_ctrlrange[i])
    if not ends:
        return np.inf, None
    low, high = max(e[0] for e in ends), min(e[1] for e in ends)
    unequal = None if np.isclose(-low, high) else f"its effort limits {low:g} and {high:g} differ, the larger holds"
    return float(max(-low, high)), unequal


def _said(constant: str) -> str:
    return constant.split("_", 1)[1].lower()
