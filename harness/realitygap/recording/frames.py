"""Orientations over time: unit quaternions w x y z as rows."""

import numpy as np

from realitygap.trace.trace import Array


def unit_quaternions(quaternion: Array) -> Array:
    """Rows of unit length whose signs do not jump (q and -q are the same orientation), so that they interpolate.

    Shape (t, 4). A row of zeros becomes NaN.
    """
    length = np.linalg.norm(quaternion, axis=1, keepdims=True)
    with np.errstate(invalid="ignore"):
        unit = quaternion / np.where(length > 1e-6, length, np.nan)
    flips = np.sum(unit[1:] * unit[:-1], axis=1) < 0
    signs = np.concatenate([[1.0], np.where(np.cumsum(flips) % 2, -1.0, 1.0)])
    return np.asarray(unit * signs[:, None])


def rotate(quaternion: Array, vector: Array) -> Array:
    """Vectors in the axes of a frame with these orientations, in world axes. Shapes (t, 4) and (t, 3), gives (t, 3)."""
    w, v = quaternion[:, :1], quaternion[:, 1:]
    turned = 2.0 * np.cross(v, vector)
    return np.asarray(vector + w * turned + np.cross(v, turned))


def angle_between(a: Array, b: Array) -> Array:
    """The angle [rad] of the rotation between orientations. Shapes (t, 4), gives (t,)."""
    chord = np.minimum(np.linalg.norm(a - b, axis=1), np.linalg.norm(a + b, axis=1))
    return np.asarray(4.0 * np.arcsin(np.clip(chord / 2.0, 0.0, 1.0)))


def rotation_vector(a: Array, b: Array) -> Array:
    """The rotation vector [rad] that turns orientation a into b, in the axes of a. Shapes (t, 4), gives (t, 3)."""
    v = a[:, :1] * b[:, 1:] - b[:, :1] * a[:, 1:] - np.cross(a[:, 1:], b[:, 1:])
    w = np.sum(a * b, axis=1, keepdims=True)
    v, w = np.where(w < 0.0, -v, v), np.abs(w)
    length = np.linalg.norm(v, axis=1, keepdims=True)
    tiny = length < 1e-9
    return np.asarray(v * np.where(tiny, 2.0, 2.0 * np.arctan2(length, w) / np.where(tiny, 1.0, length)))


def vertical(quaternion: Array) -> Array:
    """The world's upward direction in the axes of frames with these orientations. Shape (t, 4), gives (t, 3)."""
    conjugate = quaternion * np.array([1.0, -1.0, -1.0, -1.0])
    return rotate(conjugate, np.tile([0.0, 0.0, 1.0], (len(quaternion), 1)))
