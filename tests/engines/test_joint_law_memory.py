"""What the joint law foresees and remembers: stops, momentum that a blow took, and where a joint stuck."""

from typing import Any

import numpy as np
import pytest
from realitygap_engines import Ground, Physics
from realitygap_engines.law.joints import JointLaw
from realitygap_engines.model.robot import Joint, Link, Model

H, INERTIA, BLOW = 1e-3, 0.01, 0.004
SOFT = Ground(0.8, 3000.0, 50.0)
FIXED = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])


def law_of(ground: Ground, *, ballast: bool = False, **joint: Any) -> JointLaw:
    """The law of one link of 0.01 kg·m² about a vertical hinge, in an engine that knows neither rotors nor damping."""
    arm = Link("arm", 1.0, np.zeros(3), np.eye(3) * INERTIA)
    hinge = Joint("hinge", False, 0, np.eye(4), np.array([0.0, 0.0, 1.0]), **joint)
    model = Model("lever", (Link("base", 1.0, np.zeros(3), np.eye(3) * 1e-3), arm), (hinge,), False)
    return JointLaw(model, Physics(H, ground=ground), native_armature=False, native_damping=False, ballast=ballast)


def asked(
    law: JointLaw, position: float, velocity: float, damping: float = 0.0, friction: float = 0.0, effort: float = 0.0
) -> float:
    """The effort that the law has the engine apply."""
    q, w, *rest = (np.array([value]) for value in (position, velocity, effort, damping, friction))
    return float(law.effort(q, w, FIXED, *rest)[0])


@pytest.mark.parametrize("ballast", [False, True])
@pytest.mark.parametrize(("armature", "damping"), [(0.03, 0.0), (0.0, 0.1), (0.0, 200.0), (0.03, 0.5)])
def test_a_blow_that_was_not_foreseen_moves_rotor_and_damper_too(
    armature: float, damping: float, ballast: bool
) -> None:
    """The link alone takes it at first; then it has P/(I + A) of speed, and with a damper goes P/D in all."""
    law = law_of(Ground(), armature=armature, ballast=ballast)
    own = float(law.model.links[1].inertia[2, 2])
    assert own == pytest.approx(INERTIA + (armature if ballast else 0.0))
    position = velocity = 0.0
    for step in range(3000):
        velocity += (H * asked(law, position, velocity, damping) + BLOW * (step == 0)) / own
        position += H * velocity
        if step == 1 and not damping:
            assert velocity == pytest.approx(BLOW / (INERTIA + armature), rel=1e-9)
    if damping:
        assert position == pytest.approx(BLOW / damping, rel=1e-6)
    else:
        assert velocity == pytest.approx(BLOW / (INERTIA + armature), rel=1e-9)


@pytest.mark.parametrize(("ground", "back"), [(SOFT, 0.2), (Ground(), 0.0)], ids=["soft", "rigid"])
def test_a_stuck_joint_that_was_moved_goes_back_by_a_fifth_on_soft_ground(ground: Ground, back: float) -> None:
    law, moved = law_of(ground), 1e-5
    for _ in range(2):
        assert asked(law, 0.3, 0.0, friction=0.1) == 0.0
    found = asked(law, 0.3 + moved, 0.0, friction=0.1)
    assert found == pytest.approx(-INERTIA * back * moved / H**2, rel=1e-6)
    assert law.dry[0] == pytest.approx(found)


def test_a_joint_sticks_where_friction_finds_it_and_not_where_there_was_none() -> None:
    law = law_of(SOFT, armature=0.02)
    for position in (0.0, 0.1, 0.2, 0.2):
        asked(law, position, 0.0)
    assert asked(law, 0.2, 0.0, friction=0.1) == 0.0


def test_friction_that_is_gone_holds_nothing() -> None:
    law = law_of(Ground())
    asked(law, 0.0, 0.0, friction=0.1, effort=0.05)
    assert law.dry[0] == pytest.approx(-0.05)
    assert asked(law, 0.0, 0.0, effort=0.05) == 0.05
    assert law.dry[0] == 0.0


@pytest.mark.parametrize(("limit", "side"), [(-0.5, -1.0), (0.4, 1.0)])
def test_an_engines_own_stop_is_foreseen(limit: float, side: float) -> None:
    """The rotor is stopped with the link, what pushes against the stop moves neither, and what leaves it is free."""

    def at(position: float, speed: float, effort: float) -> float:
        law = law_of(Ground(), armature=0.03, lower=-0.5, upper=0.4)
        return asked(law, position, side * speed, effort=side * effort)

    share = INERTIA / (INERTIA + 0.03)
    assert at(limit, 0.0, 0.2) == pytest.approx(side * 0.2, rel=1e-4)
    assert at(limit, 0.5, 0.0) == pytest.approx(side * 0.03 * 0.5 / H, rel=1e-4)
    assert at(limit, -0.5, 0.2) == pytest.approx(side * share * 0.2, rel=1e-9)
    assert at(0.0, 0.5, 0.2) == pytest.approx(side * share * 0.2, rel=1e-9)


def test_ballast_is_what_the_links_beyond_a_joint_lack_of_its_armature() -> None:
    """A chain of four joints: the second slides and has no rotary rotor, and two hinges share what the last one has."""
    armature, slides = (0.05, 0.5, 0.02, 0.03), (False, True, False, False)
    link = Link("link", 1.0, np.zeros(3), np.eye(3) * INERTIA)
    joints = tuple(
        Joint(f"joint{i}", slide, i, np.eye(4), np.array([0.0, 0.0, 1.0]), armature=a)
        for i, (a, slide) in enumerate(zip(armature, slides, strict=True))
    )
    model = Model("chain", (link,) * 5, joints, True)
    law = JointLaw(model, Physics(H, ground=Ground()), native_armature=False, native_damping=False, ballast=True)
    added = [new.inertia[0, 0] - INERTIA for new in law.model.links]
    np.testing.assert_allclose(added, [0.0, 0.02, 0.0, 0.0, 0.03], rtol=0, atol=1e-15)
