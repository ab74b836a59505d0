"""Quaternions w x y z and vectors as plain floats, for loops in which numpy is slow on so few elements."""

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


def product(a: Quaternion, b: Quaternion) -> Quaternion:
    """Of quaternions w x y z; plain floats, because four elements are too few for numpy."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] + a[2] * b[0] + a[3] * b[1] - a[1] * b[3],
        a[0] * b[3] + a[3] * b[0] + a[1] * b[2] - a[2] * b[1],
    )


def cross(a: Vector, b: Vector) -> Vector:
    """Of two vectors."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def rotate(q: Quaternion, v: Vector) -> Vector:
    """v turned by the unit quaternion q."""
    axis = (q[1], q[2], q[3])
    t = cross(axis, v)
    u = cross(axis, t)
    return v[0] + 2 * (q[0] * t[0] + u[0]), v[1] + 2 * (q[0] * t[1] + u[1]), v[2] + 2 * (q[0] * t[2] + u[2])
