"""Friction in a joint and its gears."""

from harness.effects.effect import Effect, Page, Parameter, Values, anywhere
from harness.plant import Plant


def _own_coulomb(plant: Plant, index: int) -> dict[str, float]:
    return {"torque": float(plant.drive["coulomb"][index])}


def _coulomb(plant: Plant, indices: list[int], values: Values) -> None:
    plant.drive["coulomb"][indices] = values["torque"]
    plant.drive["static"][indices] = values["torque"]


COULOMB_FRICTION = Effect(
    name="coulomb_friction",
    changes="torque",
    sits_at="joint",
    parameters=(Parameter("torque", "N·m", 0.0, 5.0, 0.1),),
    signals=("position", "velocity"),
    own=_own_coulomb,
    apply=_coulomb,
    possible=anywhere,
    page=Page(
        physics="Dry friction of bearings, seals and gears: a torque that opposes motion and does not depend on speed. At "
        "rest it takes any value up to the bound and holds the joint.",
        equation="sliding: τ = −torque·sign(ω); stuck: |τ| ≤ torque",
        signature="The joint stops short of its goal and stays there; flat spots at reversals; a hysteresis of constant "
        "width between effort and position.",
        confused_with="stribeck_friction (without slow motion), load_dependent_friction (at one load), backlash (a flat "
        "spot at reversals too, but without an effort offset).",
        source="C. A. Coulomb 1785; Armstrong-Hélouvry, Dupont, Canudas de Wit 1994; thesis section 4.3.",
    ),
    excludes=("stribeck_friction",),
    dissipative=True,
)


def _own_viscous(plant: Plant, index: int) -> dict[str, float]:
    return {"coefficient": float(plant.drive["viscous"][index])}


def _viscous(plant: Plant, indices: list[int], values: Values) -> None:
    plant.drive["viscous"][indices] = values["coefficient"]


VISCOUS_FRICTION = Effect(
    name="viscous_friction",
    changes="torque",
    sits_at="joint",
    parameters=(Parameter("coefficient", "N·m·s/rad", 0.0, 50.0, 0.05),),
    signals=("position", "velocity"),
    own=_own_viscous,
    apply=_viscous,
    possible=anywhere,
    page=Page(
        physics="Friction of lubricated gears and bearings that grows in proportion to speed.",
        equation="τ = −coefficient·ω",
        signature="Lag and lost amplitude that grow with speed; nothing at rest.",
        confused_with="the back-EMF of the motor (resistance, torque constant), command_delay (a lag that does not depend "
        "on the load), a lower controller gain.",
        source="Armstrong-Hélouvry, Dupont, Canudas de Wit 1994; thesis section 3.4.",
    ),
    dissipative=True,
)
