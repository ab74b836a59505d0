"""Rotations between orientations, against SciPy's."""

import numpy as np
from realitygap.recording.frames import angle_between, rotation_vector
from scipy.spatial.transform import Rotation


def test_the_rotation_between_orientations_is_theirs_whatever_their_sign() -> None:
    random = np.random.default_rng(3)
    a, turn = Rotation.random(200, random_state=random), Rotation.from_rotvec(random.normal(0.0, 0.7, (200, 3)))
    first = np.roll(a.as_quat(), 1, axis=1)
    second = np.roll((a * turn).as_quat(), 1, axis=1) * random.choice([-1.0, 1.0], (200, 1))
    between = rotation_vector(first, second)
    np.testing.assert_allclose(between, turn.as_rotvec(), atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(between, axis=1), angle_between(first, second), atol=1e-7)


def test_no_rotation_is_none_and_a_tiny_one_is_not_lost() -> None:
    still = np.array([[1.0, 0.0, 0.0, 0.0]])
    assert not rotation_vector(still, still).any()
    tiny = np.array([[1.0, 0.0, 0.0, 1e-12]])
    np.testing.assert_allclose(rotation_vector(still, tiny), [[0.0, 0.0, 2e-12]], rtol=1e-9)


def test_what_was_not_measured_stays_unknown() -> None:
    one, nothing = np.array([[1.0, 0.0, 0.0, 0.0]]), np.full((1, 4), np.nan)
    assert np.isnan(rotation_vector(nothing, one)).all()
