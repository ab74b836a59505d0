"""What a first scenario guesses of a robot from its joints and from the names of its links."""

from dataclasses import replace

import numpy as np
import pytest
from realitygap.init.robot_guess import base_of, servo_lines
from realitygap_engines.model.robot import Joint, Link, Model

BODY = Link("base", 1.0, np.zeros(3), np.eye(3))
SLIDE = Joint("finger", True, 0, np.eye(4), np.array([1.0, 0.0, 0.0]), lower=0.0, upper=0.04, effort=5.0, velocity=1.0)
TURN = replace(SLIDE, name="elbow", prismatic=False, lower=-0.02, upper=0.02)


def chain(*joints: Joint, links: tuple[str, ...] = ()) -> Model:
    """A robot of one joint behind the other, with links of these names."""
    names = links or tuple(f"link{k}" for k in range(len(joints)))
    placed = tuple(replace(joint, parent=k) for k, joint in enumerate(joints))
    return Model("arm", (BODY, *(replace(BODY, name=n, merged=(n,)) for n in names)), placed, False)


@pytest.mark.parametrize(
    ("joint", "expected"),
    [
        (SLIDE, "kp: 1250  # GUESS: the URDF's effort limit of 5 at 0.004 m of error, a tenth of its travel"),
        (replace(SLIDE, lower=-1.0, upper=1.0), "kp: 50  # GUESS: the URDF's effort limit of 5 at 0.1 m of error"),
        (replace(SLIDE, upper=np.inf), "kp: 50  # GUESS: the URDF's effort limit of 5 at 0.1 m of error"),
        (replace(SLIDE, effort=np.inf), "at 0.004 m of error, a tenth of its travel"),
        (TURN, "kp: 50  # GUESS: the URDF's effort limit of 5 at 0.1 rad of error"),
    ],
)
def test_a_slide_gives_its_full_effort_at_an_error_that_it_can_have(joint: Joint, expected: str) -> None:
    assert any(line.endswith(expected) for line in servo_lines(chain(joint), "position", "arm", {}))


def test_slides_and_turns_with_the_same_limits_have_servos_of_their_own() -> None:
    lines = servo_lines(chain(SLIDE, replace(TURN, name="wrist"), TURN), "position", "arm", {})
    assert [line for line in lines if "joints:" in line] == ['  - joints: ["finger"]', '  - joints: ["wrist", "elbow"]']


@pytest.mark.parametrize(
    "name", ["left_foot", "FL-leg", "rightKnee", "r_wheel2", "lfoot", "front_left_wheels", "ANKLE"]
)
def test_a_link_that_is_called_as_a_leg_or_a_wheel_lets_the_base_float_and_is_named(name: str) -> None:
    model = chain(TURN, SLIDE, links=("upper", name))
    assert base_of(model, None, None) == ("floating", f"the link {name} is called as a leg or a wheel")


@pytest.mark.parametrize("name", ["allegro_mount", "legacy_flange", "elegant", "wheelbase", "football"])
def test_a_word_that_only_holds_a_leg_is_none(name: str) -> None:
    base, why = base_of(chain(TURN, SLIDE, links=("upper", name)), None, None)
    assert (base, why) == ("fixed", "the tree has 1 end, no legs and no wheels")
