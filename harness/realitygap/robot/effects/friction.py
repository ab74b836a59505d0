"""Friction in a joint and its gears."""

from realitygap.robot.effects.effect import Effect, Page, Parameter, Values, reads, writes
from realitygap.robot.effects.joint import anywhere, effort_scale, speed_scale
from realitygap.robot.plant import Plant

FRICTION_HIGH = 200.0
"""Bound of dry friction [N·m or N]: a linear axis of 100 kg has some tens of N."""
PRESLIDING, PRESLIDING_ALONG = 1e-3, 3e-5
"""What dry friction of gears and bearings builds up over [rad, and m of a linear axis]: 1.1 mrad of a servo (0.285 N·m
over 260 N·m/rad: Canudas de Wit, Lischinsky, Int. J. Adaptive Control and Signal Processing 11, 1997); of rolled ball
screws what they give way, 0.02 to 0.05 mm."""
PRESLIDING_STEP = 1e-4
"""An amount of that which is neither negligible nor absurd [rad or m]."""


def presliding(plant: Plant, index: int) -> float:
    """What dry friction of a joint ordinarily builds up over [rad or m]."""
    return PRESLIDING_ALONG if plant.model.joints[index].prismatic else PRESLIDING


def _coulomb(plant: Plant, indices: list[int], values: Values) -> None:
    plant.drive["coulomb"][indices] = values["torque"]
    plant.drive["static"][indices] = values["torque"]
    for name in ("onset", "presliding"):
        if name in values:
            plant.drive[name][indices] = values[name]


def _more_coulomb(plant: Plant, index: int) -> dict[str, float]:
    d = plant.drive[index]
    shape = {"onset": float(d["onset"]), "presliding": float(d["presliding"])}
    return {"torque": float(d["coulomb"]) + 0.02 * effort_scale(plant, index), **shape}


COULOMB_FRICTION = Effect(
    name="coulomb_friction",
    changes="torque",
    sits_at="joint",
    law="friction",
    parameters=(
        Parameter("torque", "N·m", 0.0, FRICTION_HIGH, 0.1),
        Parameter("onset", "rad/s", 0.0, 5.0, 0.0, absent=0.0, default=0.0, shape=True),
        Parameter("presliding", "rad", 0.0, 0.1, 0.0, absent=0.0, default=0.0, shape=True, typical=PRESLIDING_STEP),
    ),
    signals=("position", "velocity"),
    own=reads(torque="coulomb", onset="onset", presliding="presliding"),
    apply=_coulomb,
    possible=anywhere,
    scaled=_more_coulomb,
    page=Page(
        physics="Dry friction of bearings, seals and gears: a torque that opposes motion and does not depend on "
        "speed. At rest it takes any value up to the bound and holds the joint. In gears that creep it grows from rest "
        "over a speed, onset, and holds nothing. Before it slides a gear gives a little, like a spring: friction "
        "builds up over an angle, presliding, and holds; beside that an onset plays no part.",
        equation="sliding: τ = −torque·sign(ω); stuck: |τ| ≤ torque; with an onset: τ = −torque·tanh(ω/onset); with "
        "presliding: τ = −torque·s, ds/dq = (1 − s·sign(ω))/presliding",
        signature="The joint stops short of its goal and stays there; flat spots at reversals; a hysteresis of "
        "constant width between effort and position.",
        confused_with="stribeck_friction (without slow motion), load_dependent_friction (at one load), backlash (a "
        "flat spot at reversals too, but without an effort offset).",
        source="Armstrong-Hélouvry, Dupont, Canudas de Wit, Automatica 30(7), 1994; Flemming 2019, chapter 4; Gaz, "
        "Cognetti, Oliva, Robuffo Giordano, De Luca, RA-L 4(4), 2019 (a friction that is a sigmoid of the speed); "
        "P. R. Dahl, A solid friction model, 1968 (presliding).",
    ),
    excludes=("stribeck_friction", "direction_friction"),
    special_of=("stribeck_friction", "direction_friction"),
    dissipative=True,
)


def _more_viscous(plant: Plant, index: int) -> dict[str, float]:
    own = float(plant.drive["viscous"][index])
    return {"coefficient": own + 0.03 * effort_scale(plant, index) / speed_scale(plant, index)}


VISCOUS_FRICTION = Effect(
    name="viscous_friction",
    changes="torque",
    sits_at="joint",
    law="friction",
    parameters=(Parameter("coefficient", "N·m·s/rad", 0.0, 2000.0, 0.05),),
    signals=("position", "velocity"),
    own=reads(coefficient="viscous"),
    apply=writes(coefficient="viscous"),
    possible=anywhere,
    scaled=_more_viscous,
    page=Page(
        physics="Friction of lubricated gears and bearings that grows in proportion to speed.",
        equation="τ = −coefficient·ω",
        signature="Lag and lost amplitude that grow with speed; nothing at rest.",
        confused_with="torque_constant (back-EMF is viscous too, but it shows in the effort), command_delay (a lag "
        "that does not depend on the load), controller_gain (a lower one lags more, and sags at rest).",
        source="Armstrong-Hélouvry, Dupont, Canudas de Wit, Automatica 30(7), 1994; Flemming 2019, chapter 4.",
    ),
    dissipative=True,
)


def _more_stribeck(plant: Plant, index: int) -> dict[str, float]:
    coulomb = float(plant.drive["coulomb"][index]) + 0.01 * effort_scale(plant, index)
    return {"static": 2.0 * coulomb, "coulomb": coulomb, "velocity": 0.1 * speed_scale(plant, index)}


def _rising(_plant: Plant, _index: int, values: Values) -> str | None:
    return "it would grow with speed" if values["static"] <= values["coulomb"] else None


STRIBECK_FRICTION = Effect(
    name="stribeck_friction",
    changes="torque",
    sits_at="joint",
    law="friction",
    parameters=(
        Parameter("static", "N·m", 0.0, FRICTION_HIGH, 0.2),
        Parameter("coulomb", "N·m", 0.0, FRICTION_HIGH, 0.1),
        Parameter("velocity", "rad/s", 1e-3, 50.0, 0.5, logarithmic=True, shape=True),
        Parameter("exponent", "", 0.3, 4.0, 2.0, default=2.0, shape=True),
    ),
    signals=("position", "velocity"),
    own=reads(static="static", coulomb="coulomb", velocity="stribeck_velocity", exponent="stribeck_exponent"),
    apply=writes(static="static", coulomb="coulomb", velocity="stribeck_velocity", exponent="stribeck_exponent"),
    possible=anywhere,
    scaled=_more_stribeck,
    page=Page(
        physics="Dry friction that is larger at rest and in slow motion than in fast motion, because a lubricant film "
        "builds up with speed: breakaway takes more torque than sliding.",
        equation="in place of Coulomb friction: |τ| ≤ F(ω) = coulomb + (static − coulomb)·exp(−|ω/velocity|^exponent)",
        signature="Stick-slip: the joint stays, breaks away with a jump and overshoots; slow motions jerk, fast ones "
        "do not.",
        confused_with="coulomb_friction (if all motion is fast or all is slow), backlash (a jump after a reversal), "
        "torque_ripple (jerks too, but at fixed angles).",
        source="R. Stribeck 1902; Canudas de Wit, Olsson, Åström, Lischinsky, IEEE TAC 40(3), 1995 (LuGre); "
        "Armstrong-Hélouvry, Dupont, Canudas de Wit 1994.",
    ),
    excludes=("coulomb_friction", "direction_friction"),
    dissipative=True,
    absurd=_rising,
)


LOAD_DEPENDENT_FRICTION = Effect(
    name="load_dependent_friction",
    changes="torque",
    sits_at="joint",
    law="friction",
    parameters=(
        Parameter("coefficient", "", 0.0, 1.5, 0.15, absent=0.0),
        Parameter("static_coefficient", "", 0.0, 1.5, 0.0, absent=0.0, default=0.0),
        Parameter("velocity", "rad/s", 1e-3, 50.0, 1.0, default=1.0, logarithmic=True, shape=True),
        Parameter("exponent", "", 0.3, 4.0, 2.0, default=2.0, shape=True),
    ),
    signals=("position", "velocity"),
    own=reads(coefficient="load", static_coefficient="load_static", velocity="load_velocity", exponent="load_exponent"),
    apply=writes(
        coefficient="load", static_coefficient="load_static", velocity="load_velocity", exponent="load_exponent"
    ),
    possible=anywhere,
    page=Page(
        physics="Gear teeth are pressed together by the torque that they transmit, and rub the more the larger it is. "
        "What they transmit is the mean of what the motor gives, τ_m (after its back-EMF), and what reaches the link, "
        "τ_out (after the rotor's inertia and all friction): what holds and accelerates the links and their load. It "
        "adds to the bound of the other dry friction, stuck or moving. Coefficients that are published for "
        "|τ_m − τ_l|, with the load's torque τ_l = −τ_out (Rhoban's M2 to M6), count twice here.",
        equation="bound += (coefficient + static_coefficient·exp(−|ω/velocity|^exponent))·½·|τ_m + τ_out|",
        signature="A hysteresis between effort and position that widens with the load; a loaded joint holds where an "
        "unloaded one creeps to its goal.",
        confused_with="coulomb_friction or stribeck_friction (where the load is always the same: a second load parts "
        "them), torque_constant (scales both directions alike).",
        source="Duclusaud, Passault, Padois, Ly: Extended Friction Models for the Physics Simulation of Servo "
        "Actuators, 2025 (arXiv 2410.08650), model M4.",
    ),
    dissipative=True,
)
