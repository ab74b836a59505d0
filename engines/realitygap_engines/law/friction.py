"""Dry friction on a tree of joints: which of them stick over a step, and what holds them.

A box-constrained linear complementarity problem, solved exactly by block principal pivoting (Júdice and Pires 1994):
joints that contradict their set are moved all at once while that lowers their number, else the last one alone, which
ends in finitely many moves. Factorisations use the branches of the tree (L^T D L; Featherstone, Rigid Body Dynamics
Algorithms, 2008, section 6.4).
"""
# mypy: allow-untyped-defs
# (compiled into `law.joints`)

from numba import njit


@njit(cache=True)
def stick_slip(matrix, factor, ancestor, right, change, residual, speed, friction, h, aim, stick, dry):
    """Solve matrix @ change = right + h * dry for the change of velocity and the dry friction of all joints.

    Args:
        matrix: symmetric, zero off the branches; the lower triangle is used. Shape (nv, nv).
        factor: room for its factors. Shape (nv, nv).
        ancestor: the next coordinate towards the root, -1 at the end. Shape (nv,).
        right: the impulse [N·s or N·m·s]. Shape (nv,).
        change: out: the change of velocity. Shape (nv,).
        residual: room. Shape (nv,).
        speed: the velocity before. Shape (nv,); the joints are the last n coordinates.
        friction: bound of the dry friction. Shape (n,).
        h: the step [s].
        aim: the velocity that a stuck joint is given. Shape (n,).
        stick: in, a first guess, and out: 0 for a stuck joint, the sign of its velocity for a sliding one. Shape (n,).
        dry: out: the dry friction. Shape (n,).
    """
    n, nv = len(stick), len(right)
    first = nv - n
    best, tries = n + 1, 4
    for _ in range(8 * n + 8):
        for i in range(nv):
            stuck = i >= first and friction[i - first] > 0 and stick[i - first] == 0
            change[i] = aim[i - first] - speed[i] if stuck else 0.0
        _multiply(matrix, ancestor, change, residual)
        for i in range(nv):
            residual[i] = right[i] - residual[i]
            stuck = i >= first and friction[i - first] > 0 and stick[i - first] == 0
            j = i
            while j >= 0:
                off = stuck or (j >= first and friction[j - first] > 0 and stick[j - first] == 0)
                factor[i, j] = matrix[i, j] if not off else (1.0 if i == j else 0.0)
                j = ancestor[j]
            if stuck:
                residual[i] = change[i]
            elif i >= first and friction[i - first] > 0:
                residual[i] -= h * stick[i - first] * friction[i - first]
        _factorise(factor, ancestor)
        _substitute(factor, ancestor, residual)
        for i in range(nv):
            change[i] = residual[i]
        _multiply(matrix, ancestor, change, residual)
        wrong, last = 0, -1
        for i in range(n):
            dry[i] = 0.0
            if friction[i] > 0:
                if stick[i] == 0:
                    dry[i] = (residual[first + i] - right[first + i]) / h
                else:
                    dry[i] = -stick[i] * friction[i]
                if _contradicts(stick[i], dry[i], friction[i], speed[first + i] + change[first + i]):
                    wrong, last = wrong + 1, i
        if wrong == 0:
            break
        if wrong < best:
            best, tries = wrong, 4
        else:
            tries -= 1
        for i in range(n):
            moves = friction[i] > 0 and (tries >= 0 or i == last)
            if moves and _contradicts(stick[i], dry[i], friction[i], speed[first + i] + change[first + i]):
                stick[i] = 0 if stick[i] != 0 else (-1 if dry[i] > 0 else 1)
    for i in range(n):
        dry[i] = min(max(dry[i], -friction[i]), friction[i])


@njit(cache=True, inline="always")
def _contradicts(stick, dry, friction, velocity):
    return abs(dry) > friction * (1 + 1e-9) if stick == 0 else stick * velocity < -1e-12


@njit(cache=True)
def _multiply(matrix, ancestor, x, out):
    """The product of a branch-sparse symmetric matrix, of which the lower triangle is used, and x."""
    for i in range(len(x)):
        out[i] = matrix[i, i] * x[i]
        j = ancestor[i]
        while j >= 0:
            out[i] += matrix[i, j] * x[j]
            out[j] += matrix[i, j] * x[i]
            j = ancestor[j]


@njit(cache=True)
def _factorise(matrix, ancestor):
    """L^T D L in place."""
    for k in range(len(ancestor) - 1, -1, -1):
        i = ancestor[k]
        while i >= 0:
            a = matrix[k, i] / matrix[k, k]
            j = i
            while j >= 0:
                matrix[i, j] -= a * matrix[k, j]
                j = ancestor[j]
            matrix[k, i] = a
            i = ancestor[i]


@njit(cache=True)
def _substitute(factor, ancestor, x):
    """Solve L^T D L x = b in place."""
    for i in range(len(x) - 1, -1, -1):
        j = ancestor[i]
        while j >= 0:
            x[j] -= factor[i, j] * x[i]
            j = ancestor[j]
    for i in range(len(x)):
        x[i] /= factor[i, i]
        j = ancestor[i]
        while j >= 0:
            x[i] -= factor[i, j] * x[j]
            j = ancestor[j]
