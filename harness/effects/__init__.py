"""The effects: physics that a model may lack. Adding one is one definition and one line in `EFFECTS`."""

from harness.effects.effect import Effect, Page, Parameter, Values
from harness.effects.friction import COULOMB_FRICTION, VISCOUS_FRICTION

__all__ = ["EFFECTS", "Effect", "Page", "Parameter", "Values"]

EFFECTS: dict[str, Effect] = {
    effect.name: effect
    for effect in (
        COULOMB_FRICTION,
        VISCOUS_FRICTION,
    )
}
"""In the order in which the simpler of two explanations is preferred."""
