"""The C library of ODE, bound by ctypes: the calls that the adapter makes, with their types, and nothing else.

Loaded privately, so that another ODE in the process (DART carries one) stays its own. ODE ends the process where it
meets an error of its own (`exit(1)`); the adapter looks at what it passes instead. Its messages are silenced.
"""

import ctypes
import ctypes.util
from pathlib import Path

import numpy as np

from realitygap_engines.errors import Unsupported
from realitygap_engines.model.robot import Array

INSTALL = "apt-get install libode8"

real, whole, handle, nothing = ctypes.c_double, ctypes.c_int, ctypes.c_void_p, None
LO_STOP, HI_STOP, VEL, FMAX, CFM = 0, 1, 2, 5, 8
"""Parameters of joints (common.h)."""
MU2, FDIR1, SOFT_ERP, SOFT_CFM, APPROX_1 = 0x001, 0x002, 0x008, 0x010, 0x7000
"""Modes of a contact (contact.h)."""


class Surface(ctypes.Structure):
    """dSurfaceParameters."""

    _fields_ = [("mode", whole)] + [
        (name, real)
        for name in (
            *("mu", "mu2", "rho", "rho2", "rho_n", "bounce", "bounce_vel", "soft_erp", "soft_cfm"),
            *("motion1", "motion2", "motion_n", "slip1", "slip2"),
        )
    ]


class ContactGeometry(ctypes.Structure):
    """dContactGeom."""

    _fields_ = [
        ("position", real * 4),
        ("normal", real * 4),
        ("depth", real),
        ("geometries", handle * 2),
        ("sides", whole * 2),
    ]


class Contact(ctypes.Structure):
    """dContact."""

    _fields_ = [("surface", Surface), ("geometry", ContactGeometry), ("direction", real * 4)]


class Mass(ctypes.Structure):
    """dMass: the inertia in rows of four."""

    _fields_ = [("mass", real), ("centre", real * 4), ("inertia", real * 12)]


class Feedback(ctypes.Structure):
    """dJointFeedback: force and torque on the first body and on the second."""

    _fields_ = [(name, real * 4) for name in ("force1", "torque1", "force2", "torque2")]


class _Symbol(ctypes.Structure):
    """Dl_info of dlfcn.h."""

    _fields_ = [("file", ctypes.c_char_p), ("base", handle), ("name", ctypes.c_char_p), ("address", handle)]


Message = ctypes.CFUNCTYPE(None, whole, ctypes.c_char_p, handle)
_three = (handle, real, real, real)
SIGNATURES: dict[str, tuple[object, tuple[object, ...]]] = {
    "dAllocateODEDataForThread": (whole, (ctypes.c_uint,)),
    "dCheckConfiguration": (whole, (ctypes.c_char_p,)),
    "dInitODE2": (whole, (ctypes.c_uint,)),
    "dRandGetSeed": (ctypes.c_ulong, ()),
    "dRandSetSeed": (nothing, (ctypes.c_ulong,)),
    "dSetMessageHandler": (nothing, (Message,)),
    "dWorldCreate": (handle, ()),
    "dWorldDestroy": (nothing, (handle,)),
    "dWorldQuickStep": (whole, (handle, real)),
    "dWorldStep": (whole, (handle, real)),
    "dWorldSetAutoDisableFlag": (nothing, (handle, whole)),
    "dWorldSetCFM": (nothing, (handle, real)),
    "dWorldSetContactMaxCorrectingVel": (nothing, (handle, real)),
    "dWorldSetContactSurfaceLayer": (nothing, (handle, real)),
    "dWorldSetERP": (nothing, (handle, real)),
    "dWorldSetGravity": (nothing, _three),
    "dWorldSetQuickStepNumIterations": (nothing, (handle, whole)),
    "dWorldSetQuickStepW": (nothing, (handle, real)),
    "dWorldGetAutoDisableFlag": (whole, (handle,)),
    "dWorldGetCFM": (real, (handle,)),
    "dWorldGetContactMaxCorrectingVel": (real, (handle,)),
    "dWorldGetContactSurfaceLayer": (real, (handle,)),
    "dWorldGetERP": (real, (handle,)),
    "dWorldGetQuickStepNumIterations": (whole, (handle,)),
    "dWorldGetQuickStepW": (real, (handle,)),
    "dBodyCreate": (handle, (handle,)),
    "dBodyAddForce": (nothing, _three),
    "dBodyAddTorque": (nothing, _three),
    "dBodyGetAngularVel": (handle, (handle,)),
    "dBodyGetLinearVel": (handle, (handle,)),
    "dBodyGetMass": (nothing, (handle, handle)),
    "dBodyGetPosition": (handle, (handle,)),
    "dBodyGetQuaternion": (handle, (handle,)),
    "dBodyGetRotation": (handle, (handle,)),
    "dBodySetAngularVel": (nothing, _three),
    "dBodySetFiniteRotationMode": (nothing, (handle, whole)),
    "dBodySetForce": (nothing, _three),
    "dBodySetGyroscopicMode": (nothing, (handle, whole)),
    "dBodySetKinematic": (nothing, (handle,)),
    "dBodySetLinearVel": (nothing, _three),
    "dBodySetMass": (nothing, (handle, handle)),
    "dBodySetPosition": (nothing, _three),
    "dBodySetQuaternion": (nothing, (handle, handle)),
    "dBodySetTorque": (nothing, _three),
    "dJointAttach": (nothing, (handle, handle, handle)),
    "dJointCreateAMotor": (handle, (handle, handle)),
    "dJointCreateContact": (handle, (handle, handle, handle)),
    "dJointCreateHinge": (handle, (handle, handle)),
    "dJointCreateLMotor": (handle, (handle, handle)),
    "dJointCreateSlider": (handle, (handle, handle)),
    "dJointGroupCreate": (handle, (whole,)),
    "dJointGroupDestroy": (nothing, (handle,)),
    "dJointGroupEmpty": (nothing, (handle,)),
    "dJointAddHingeTorque": (nothing, (handle, real)),
    "dJointAddSliderForce": (nothing, (handle, real)),
    "dJointGetHingeAnchor": (nothing, (handle, handle)),
    "dJointGetHingeAngle": (real, (handle,)),
    "dJointGetHingeAngleRate": (real, (handle,)),
    "dJointGetHingeAxis": (nothing, (handle, handle)),
    "dJointGetSliderAxis": (nothing, (handle, handle)),
    "dJointGetSliderPosition": (real, (handle,)),
    "dJointGetSliderPositionRate": (real, (handle,)),
    "dJointSetAMotorAxis": (nothing, (handle, whole, whole, real, real, real)),
    "dJointSetAMotorNumAxes": (nothing, (handle, whole)),
    "dJointSetAMotorParam": (nothing, (handle, whole, real)),
    "dJointSetFeedback": (nothing, (handle, handle)),
    "dJointSetHingeAnchor": (nothing, _three),
    "dJointSetHingeAxis": (nothing, _three),
    "dJointSetHingeParam": (nothing, (handle, whole, real)),
    "dJointSetLMotorAxis": (nothing, (handle, whole, whole, real, real, real)),
    "dJointSetLMotorNumAxes": (nothing, (handle, whole)),
    "dJointSetLMotorParam": (nothing, (handle, whole, real)),
    "dJointSetSliderAxis": (nothing, _three),
    "dJointSetSliderParam": (nothing, (handle, whole, real)),
}


def open_library() -> ctypes.CDLL:
    """ODE, initialised and quiet.

    Raises:
        Unsupported: where it is not installed, or was built with single precision.
    """
    name = ctypes.util.find_library("ode")
    if name is None:
        raise Unsupported(f"engine ode is not installed; install it with: {INSTALL}")
    library = ctypes.CDLL(name)
    for function, (result, arguments) in SIGNATURES.items():
        bound = getattr(library, function)
        bound.restype, bound.argtypes = result, arguments
    if not library.dCheckConfiguration(b"ODE_double_precision"):
        raise Unsupported(f"{name} was built with single precision, and double is needed; install it with: {INSTALL}")
    library.dInitODE2(0)
    library.dAllocateODEDataForThread(0xFFFFFFFF)
    library.dSetMessageHandler(_silent)
    return library


@Message
def _silent(number: int, message: bytes, arguments: int) -> None:
    """What ODE has to say of a step, such as an LCP that its pivoting cannot finish."""


def version_of(library: ctypes.CDLL) -> str:
    """The version in the name of the library's file, such as 8.0.2 of libode.so.8.0.2; ODE itself tells none."""
    found = _Symbol()
    ctypes.CDLL(None).dladdr(library.dWorldCreate, ctypes.byref(found))
    name = Path(found.file.decode()).resolve().name
    return name.partition(".so.")[2] or name


def view(address: int, size: int) -> Array:
    """The numbers that lie at an address, not copied. Shape (size,)."""
    return np.ctypeslib.as_array(ctypes.cast(address, ctypes.POINTER(real)), (size,))


def real_array(*values: float) -> "ctypes.Array[ctypes.c_double]":
    """Numbers as C has them."""
    return (real * len(values))(*values)
