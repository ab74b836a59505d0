"""What to record next: the recording that separates two effects that cannot be told apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from realitygap.diagnose.data.changes import Suspect

SEPARATES = {
    frozenset(
        {"link_mass", "center_of_mass"}
    ): "repeat a motion with a known second load: mass and centre of mass part there",
    frozenset({"link_mass", "constant_effort"}): "hold the joint at several angles on both sides of the vertical",
    frozenset({"joint_offset", "constant_effort"}): "repeat a motion at another controller gain: an offset stays, the "
    "deflection by a torque shrinks",
    frozenset({"joint_offset", "base_tilt"}): "measure the base with a level, or turn the robot by 180°",
    frozenset(
        {"base_tilt", "constant_effort"}
    ): "swing the joint far to both sides: the pull of a tilt changes with the angle",
    frozenset(
        {"center_of_mass", "base_tilt"}
    ): "turn the robot by 180°: a tilt changes its sign, a centre of mass does not",
    frozenset({"rotor_inertia", "link_inertia"}): "repeat a fast motion with a known second load",
    frozenset(
        {"rotor_inertia", "command_delay"}
    ): "let the joint swing freely with the servo off: there is no delay then",
    frozenset({"viscous_friction", "command_delay"}): "let the joint swing freely with the servo off",
    frozenset({"coulomb_friction", "stribeck_friction"}): "a slow triangle, well below the Stribeck velocity",
    frozenset({"coulomb_friction", "load_dependent_friction"}): "repeat the motion with a second load",
    frozenset({"coulomb_friction", "backlash"}): "record the motor's effort in a slow triangle",
    frozenset(
        {"supply_voltage", "torque_constant"}
    ): "measure the supply, or record a fast motion near the speed limit",
    frozenset({"supply_voltage", "controller_gain"}): "measure the supply, or drive the servo into saturation",
    frozenset({"torque_constant", "controller_gain"}): "record the motor's current, or a motion near the speed limit",
    frozenset({"supply_voltage", "voltage_sag"}): "record the supply voltage",
    frozenset({"backlash", "joint_compliance"}): "hold the output and load it in steps to both sides",
}
"""The recording that separates two effects."""
DRIVEN = "a motion with another load, another gain and a phase with the servo off"
SEPARATES_FOLLOWED = {
    frozenset({"joint_offset", "constant_effort"}): "hold the arm in many poses: what an offset does "
    "to gravity changes with the angle, a constant effort does not",
}
"""What takes its place where no servo has a gain."""
FOLLOWED = "a motion with another load, slow and fast, through poses that gravity loads otherwise"
"""What is recorded where no more is known, of a motion that servos drive and of one that is followed."""


def experiment(listed: Mapping[Suspect, Sequence[Sequence[Suspect]]], followed: bool = False) -> str:
    """What to record to settle what cannot be told apart; empty where nothing is open.

    Args:
        listed: of each finding the rivals, each as the suspects that stand there together: of these one counts that a
            recording is known for.
        followed: whether motions are followed: no servo has a gain or can be off.
    """
    separates = {**SEPARATES, **SEPARATES_FOLLOWED} if followed else SEPARATES
    advice = []
    for owner, others in listed.items():
        for together in others:
            known = {s: separates.get(frozenset({owner.effect, s.effect}), "") for s in together}
            rival = next((s for s, said in known.items() if said), together[0])
            advice.append(f"{owner} or {rival}: {known[rival] or (FOLLOWED if followed else DRIVEN)}")
    return "; ".join(dict.fromkeys(advice))
