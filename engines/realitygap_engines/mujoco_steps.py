"""What is compiled of a step in MuJoCo: its C function, the base in world axes, and damping beside soft contacts."""

import ctypes
from functools import cache
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from realitygap_engines.law.compiled import compiled

ADDRESS = ctypes.c_int64
MORE: dict[str, list[Any]] = {"mj_rne": [ctypes.c_int, ADDRESS], "mju_copy": [ctypes.c_int]}
"""What functions take besides two addresses."""


@cache
def loaded() -> ctypes.CDLL | None:
    """The library that the bindings have loaded; None where it does not lie beside them."""
    beside = Path(mujoco.__file__).parent
    found = [p for form in ("libmujoco.so.*", "libmujoco.*.dylib", "mujoco.dll") for p in beside.glob(form)]
    return ctypes.CDLL(str(found[0])) if len(found) == 1 else None


def clock() -> ctypes.c_void_p | None:
    """Where the library has the function that it asks for the time, which the bindings set; None without a library.

    `mujoco.set_mjcb_time(None)` does not take that out. A step of an arm of two links asks a dozen times, for a quarter
    of what the step takes.
    """
    library = loaded()
    return None if library is None else ctypes.c_void_p.in_dll(library, "mjcb_time")


@cache
def c_functions(*names: str) -> tuple[Any, ...] | None:
    """Functions of the library that the bindings have loaded, in C, of the addresses of model and data.

    `mj_rne` also takes a flag and the address of its result; `mju_copy` takes addresses to and from, and a number. None
    where the library does not lie beside the bindings.
    """
    library = loaded()
    if library is None:
        return None
    functions = tuple(getattr(library, name) for name in names)
    for name, function in zip(names, functions, strict=True):
        function.argtypes, function.restype = [ADDRESS, ADDRESS, *MORE.get(name, [])], None
    return functions


STEP = ("mj_step", "mju_copy")
"""What a step takes, and reading what dry friction gave in it."""


def word(data: "mujoco.MjData", number: int) -> NDArray[np.int64]:
    """A word of an `mjData` itself, as it is in memory. Shape (1,)."""
    return np.ctypeslib.as_array((ctypes.c_int64 * 1).from_address(data._address + 8 * number))


@cache
def force_word() -> int | None:
    """Which word of an `mjData` is its pointer `efc_force`, which moves as contacts come and go.

    Found in one whose only constraint is a dry joint. None where the words up to the last one, the signature, do not
    tell.
    """
    spec = mujoco.MjSpec()
    body = spec.worldbody.add_body(mass=1.0, inertia=[1.0, 1.0, 1.0])
    body.add_joint(frictionloss=1.0)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    address, found, k = data.efc_force.ctypes.data, list[int](), 0
    while (value := ctypes.c_uint64.from_address(data._address + 8 * k).value) != data.signature:
        found += [k] if value == address else []
        k += 1
    return found[0] if len(found) == 1 else None


@compiled
def inverse(functions, model, data, q, w, a, position, velocity, acceleration, out):  # type: ignore[no-untyped-def]
    """Write the efforts of a motion, all Shape (t, n), to `out`; `functions` are those of `INVERSE`, in C.

    `q`, `w` and `a` (n,) are the coordinates, velocities and accelerations at the addresses of model and data.
    """
    kinematics, places, rates, newton_euler = functions
    for k in range(len(position)):
        q[:], w[:], a[:] = position[k], velocity[k], acceleration[k]
        kinematics(model, data)
        places(model, data)
        rates(model, data)
        newton_euler(model, data, 1, out[k].ctypes.data)


INVERSE = ("mj_kinematics", "mj_comPos", "mj_comVel", "mj_rne")
"""Recursive Newton-Euler alone: mj_inverse would add limits."""


@compiled
def read_bases(base):  # type: ignore[no-untyped-def]
    """Rows of pose and velocity as MuJoCo has them, Shape (t, 13), as `read` writes them, in place."""
    for k in range(len(base)):
        read_base(base[k, :7].copy(), base[k, 7:].copy(), base[k])


@compiled
def read_base(pose, velocity, base):  # type: ignore[no-untyped-def]
    """Write pose (7,) and velocity (6,) of the base, whose angular velocity MuJoCo has in axes of the base."""
    base[:7] = pose
    base[7:] = velocity
    w, x, y, z = pose[3], pose[4], pose[5], pose[6]
    a, b, c = velocity[3], velocity[4], velocity[5]
    tx, ty, tz = 2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)
    base[10] = a + w * tx + y * tz - z * ty
    base[11] = b + w * ty + z * tx - x * tz
    base[12] = c + w * tz + x * ty - y * tx


@compiled
def undamp(jacobian, address, inertia, diagonal, damping, h, solref):  # type: ignore[no-untyped-def]
    """Scale every contact's solref by what joint damping does to the A of `soften`.

    The discrete integrator scales the A of a row J by Σ J²/(M_jj + h·D_j) / Σ J²/M_jj (MuJoCo's documentation,
    "Impedance"). `jacobian` is Shape (nefc·nv,) and `address` the first row of every contact in it, -1 where the two
    only just touch; `diagonal` tells where in `inertia` a row of M ends, with its diagonal element.
    """
    nv = len(damping)
    for i in range(len(solref)):
        if address[i] < 0:
            continue
        bare, damped = 0.0, 0.0
        for j in range(nv):
            square = jacobian[address[i] * nv + j] ** 2
            own = inertia[diagonal[j] - 1]
            bare += square / own
            damped += square / (own + h * damping[j])
        solref[i, 0] *= damped / bare
        solref[i, 1] *= damped / bare
