"""Compliance and backlash against what a pencil says: resonance, rest, impact, momentum and energy."""

from dataclasses import replace

import numpy as np
import pytest
import realitygap_engines as engines
from numpy.testing import assert_allclose
from one_joint import (
    ARMATURE,
    AT_REST,
    LENGTH,
    LINK,
    MASS,
    RESISTANCE,
    SUPPLY,
    TORQUE_CONSTANT,
    H,
    added,
    effort_servo,
    everywhere,
    pendulum,
    run,
    solves_exactly,
    wheel,
)
from realitygap.robot.drive import LOG, STATE
from realitygap.robot.drive_law import arrive, drive_effort
from realitygap_engines import Physics, State
from realitygap_engines.model.robot import Link


@everywhere
def test_compliance_rings_at_its_resonance(engine: str) -> None:
    """√(k·(1/I₁ + 1/I₂)) of a free rotor and link, and their common speed stays."""
    plant = added(effort_servo(wheel()), "joint_compliance", stiffness=100.0)
    out = run(plant, 0.0, 1.0, engine=engine, velocity=0.0)
    assert np.abs(out.position).max() < AT_REST
    plant.drive["constant"] = 0.05  # pushes the link, which pulls the rotor
    out = run(plant, 0.0, 1.0, engine=engine)
    steady = 0.05 / (LINK + ARMATURE)
    ringing = out.velocity[:, 0] - steady * (out.time + H / 2)
    crossings = out.time[1:][(ringing[:-1] < 0) & (ringing[1:] >= 0)]
    found = 2 * np.pi / np.diff(crossings).mean()
    assert_allclose(found, np.sqrt(100.0 * (1 / LINK + 1 / ARMATURE)), rtol=5e-3)
    # the rotor is driven by 1 − cos: its speed swings about the common one by steady·sin(Ωt)/Ω
    assert_allclose(ringing.max(), steady / found, rtol=0.02)
    assert_allclose(ringing[-200:].max(), ringing[:200].max(), rtol=0.02, err_msg="a spring does not lose energy")


@everywhere
def test_the_encoder_does_not_see_what_the_spring_gives_way(engine: str) -> None:
    plant = added(pendulum(), "joint_compliance", stiffness=20.0)
    plant = added(plant, "viscous_friction", coefficient=0.5)
    plant = added(plant, "constant_effort", effort=0.4)
    out = run(plant, 0.3, 4.0, engine=engine)
    stiffness = 5.0 * SUPPLY * TORQUE_CONSTANT / RESISTANCE
    transmitted = stiffness * (0.3 - out.position[-1, 0])
    link = out.position[-1, 0] - transmitted / 20.0
    assert_allclose(transmitted, MASS * 9.81 * LENGTH * np.sin(link) - 0.4, atol=1e-4)


@pytest.mark.parametrize("link_inertia", [4.5e-4, 0.05])
@pytest.mark.parametrize("stiffness", [5.0, 1e3, 1e6])
def test_compliance_is_stable_at_1_ms_with_light_links(link_inertia: float, stiffness: float) -> None:
    plant = wheel()
    links = (plant.model.links[0], Link("arm0", 1e-3, np.zeros(3), np.eye(3) * link_inertia))
    plant.model = replace(plant.model, links=links)
    plant.drive["viscous"] = 0.03
    rigid = run(plant, 0.5)
    out = run(added(plant, "joint_compliance", stiffness=stiffness), 0.5)
    assert np.abs(out.position).max() < 0.7
    assert_allclose(out.position[-1], 0.5, atol=0.1 if stiffness == 5.0 else 0.02)
    if stiffness == 1e6:
        assert_allclose(out.position, rigid.position, atol=2e-3)


@everywhere
def test_backlash_rests_in_its_dead_zone_and_lands_at_its_end(engine: str) -> None:
    """The motor pushes, lets go, and pulls: it crosses the whole width before the link moves the other way."""
    width, torque = 0.1, 0.3
    plant = added(effort_servo(wheel()), "backlash", angle=width)
    t = np.arange(2000) * 1e-3
    out = run(plant, np.where(t < 0.2, torque, -torque), 0.6, engine=engine)
    # from the middle, the free rotor crosses half of the width; the link rests meanwhile
    alone = torque / ARMATURE
    first = np.sqrt(width / alone)
    assert np.abs(out.position[out.time < first - 2 * H]).max() < AT_REST
    # an impact without rebound: the momentum is shared
    speed = alone * first * ARMATURE / (ARMATURE + LINK)
    landed = int(np.searchsorted(out.time, first)) + 3
    assert_allclose(out.velocity[landed, 0], speed + (out.time[landed] - first) * torque / (ARMATURE + LINK), rtol=0.02)
    # from 0.2 s on the rotor pulls back over the full width, while the link goes on at constant speed
    back = np.sqrt(2 * width / alone)
    free = (out.time > 0.2 + 3 * H) & (out.time < 0.2 + back - 3 * H)
    assert np.ptp(out.velocity[free, 0]) < 1e-6
    assert out.velocity[int(np.searchsorted(out.time, 0.2 + back)) + 3, 0] < out.velocity[free, 0].min() - 0.1


@everywhere
def test_a_link_that_runs_away_from_its_rotor_is_free_across_the_play(engine: str) -> None:
    """The motor still drives towards the end that its rotor lies at, and a load pulls the link away faster."""
    width, torque, load = 0.1, 0.5, 0.6
    plant = added(added(effort_servo(wheel()), "backlash", angle=width), "constant_effort", effort=load)
    t = np.arange(2000) * 1e-3
    out = run(plant, np.where(t < 0.1, 3.0, torque), 0.3, engine=engine)
    close = 1e-6 if solves_exactly(engine) else 3e-3
    crossing = np.sqrt(2 * width / (load / LINK - torque / ARMATURE))
    free = (out.time > 0.1 + 3 * H) & (out.time < 0.1 + crossing - 3 * H)
    assert_allclose(np.diff(out.velocity[free, 0]) / H, load / LINK, rtol=close)
    together = out.time > 0.1 + crossing + 3 * H
    assert_allclose(np.diff(out.velocity[together, 0]) / H, (load + torque) / (LINK + ARMATURE), rtol=close)


def test_play_takes_energy_and_keeps_momentum() -> None:
    """Rotor and link bounce to and fro in the dead zone: each impact shares the momentum and loses energy."""
    plant = added(effort_servo(wheel()), "backlash", angle=0.05)
    start, steps = State(np.zeros(1), np.array([2.0])), 400
    state, log = np.zeros(1, STATE), np.zeros((steps + 1, 1), LOG)
    state["velocity"] = 2.0
    q, w, base = np.zeros(1), np.zeros(1), np.zeros(13)
    law = [np.zeros(1) for _ in range(3)]
    link = []
    command, dry = np.zeros(1), np.zeros(1)
    with engines.load("mujoco").open(plant.machine(), Physics(H)) as simulation:
        simulation.reset(start)
        for k in range(steps):
            simulation.read(q, w, base)
            link.append(w[0])
            # the rotor rests at first: the state knows it before the first step
            if k == 0:
                state["begun"], state["mass"] = 1, ARMATURE
            drive_effort(plant.drive, state, command, command, q, w, dry, plant.inertia(), 0.0, k * H, H, *law, log[k])
            simulation.step(*law)
        simulation.read(q, w, base)
        arrive(plant.drive, state, q, w, dry, H, log[steps])
    rotor, moving = log["rotor"][:steps, 0], np.array(link)
    momentum = LINK * moving + ARMATURE * rotor
    assert_allclose(momentum, momentum[0], rtol=1e-9)
    energy = LINK * moving**2 + ARMATURE * rotor**2
    assert np.diff(energy).max() < 1e-9 * energy[0]
    assert_allclose(moving[-1], 2.0 * LINK / (LINK + ARMATURE), rtol=1e-3)
