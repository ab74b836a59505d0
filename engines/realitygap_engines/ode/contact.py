"""Contact of the model's spheres with the plane z = 0 as contact joints of ODE, made anew for every step.

ODE's own sphere and plane give the same one point, at the sphere's surface, with the same depth; calling its collision
detection back from Python would cost more than the step. ERP = h k/(h k + d) and CFM = 1/(h k + d) are Gazebo's mapping
of stiffness k and damping d: the force of the spring and damper at the end of the step. A point that slides has the
cone's friction, against its slip and none across it: across it, friction would hold the point where an impact turns the
body, with 1.4 times the cone's force. One that creeps or rests has a pyramid and holds up to 1.4 times as much askew.

dWorldStep bounds friction by the load that a point would have if no point had friction (dContactApprox1), and with both
feet on the ground that is another one: feet that hold against each other stick where they should slide. A point that
was loaded before has its bound from the load of the steps before instead. quickStep needs no such help: it sets the
bound anew in every sweep.
"""

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass, field
from math import hypot

from realitygap_engines.engine import Physics
from realitygap_engines.model.robot import Model
from realitygap_engines.ode import library as ode_library
from realitygap_engines.ode.library import Contact, Feedback
from realitygap_engines.ode.robot import OdeLink, ode

LAYER = 1e-5
"""Depth of rigid contacts that is not corrected [m], so that they do not come and go."""
SLIP = 1e-6
"""A contact point that is slower has no direction of slip [m/s]."""
SLIDES = 0.01
"""A contact point that is slower may come to rest within a step, and is held in every direction [m/s]."""


@dataclass(slots=True)
class ContactPoint:
    """A sphere, its centre in the frame of the link's centre of mass [m], and what the ground pressed it with [N].

    Attributes:
        load: of the step before, as ODE reports it.
        earlier: the normal force of the step before that.
    """

    x: float
    y: float
    z: float
    radius: float
    load: Feedback = field(default_factory=Feedback)
    earlier: float = 0.0

    def expected(self, *, smooth: bool) -> float:
        """The normal force to expect in this step, 0 where that is not known: the line through the last two where they
        change smoothly; the smaller of them on rigid ground, where an impact takes one step. Asked once per step: the
        last load becomes the earlier one.
        """
        last: float = self.load.force1[2]
        earlier = self.earlier
        self.earlier = last
        if earlier <= 0.0:
            return 0.0
        return 2.0 * last - earlier if smooth else min(last, earlier)

    def lift(self) -> None:
        """Forget the loads: the point is in the air."""
        self.load.force1[2] = self.earlier = 0.0


class ContactPoints:
    """The contacts of one robot.

    Attributes:
        friction: of the pair.
        erp: of soft contacts; None where the world's holds.
        cfm: of soft contacts; None where the world's holds.
    """

    def __init__(self, world: int, model: Model, links: Sequence[OdeLink], physics: Physics) -> None:
        ground = physics.ground
        assert ground is not None
        self.friction = ground.friction
        self.erp: float | None = None
        self.cfm: float | None = None
        self._pivoting = physics.solver_iterations is None
        self._world = world
        self._group = ode.dJointGroupCreate(0)
        self._contact = contact = Contact()
        self._pointer = ctypes.byref(contact)
        surface = contact.surface
        surface.mode = ode_library.FDIR1 | ode_library.MU2 | ode_library.APPROX_1
        surface.mu = ground.friction
        if ground.stiffness is not None:
            spring, damper = physics.timestep * ground.stiffness, ground.damping or 0.0
            self.erp = surface.soft_erp = spring / (spring + damper)
            self.cfm = surface.soft_cfm = 1 / (spring + damper)
            surface.mode |= ode_library.SOFT_ERP | ode_library.SOFT_CFM
        ode.dWorldSetContactSurfaceLayer(world, LAYER if self.erp is None else 0.0)
        contact.geometry.normal[:] = [0.0, 0.0, 1.0, 0.0]
        self._feet = []
        for i, (link, part) in enumerate(zip(model.links, links, strict=True)):
            spheres = link.spheres if i or model.floating else ()
            centers = ((s.center - link.com).tolist() for s in spheres)
            points = [ContactPoint(x, y, z, s.radius) for (x, y, z), s in zip(centers, spheres, strict=True)]
            if points:
                reach = max(hypot(p.x, p.y, p.z) + p.radius for p in points)
                self._feet.append((part, points, reach))

    def reset(self) -> None:
        """Forget the loads of earlier steps."""
        for _, points, _ in self._feet:
            for point in points:
                point.lift()

    def make(self) -> None:
        """Make a contact joint for every sphere that touches the plane now."""
        contact, position, direction = self._contact, self._contact.geometry.position, self._contact.direction
        surface, smooth = contact.surface, self.erp is not None
        bounded = surface.mode & ~ode_library.APPROX_1
        for link, points, reach in self._feet:
            px, py, pz = link.position.tolist()
            if pz > reach:
                continue
            a, b, c, _, d, e, f, _, g, h, i, _ = link.rotation.tolist()
            vx, vy, _ = link.linear.tolist()
            wx, wy, wz = link.angular.tolist()
            for point in points:
                x, y, z = point.x, point.y, point.z
                rz = g * x + h * y + i * z - point.radius
                if pz + rz > 0.0:
                    point.lift()
                    continue
                rx, ry = a * x + b * y + c * z, d * x + e * y + f * z
                ux, uy = vx + wy * rz - wz * ry, vy + wz * rx - wx * rz
                speed = hypot(ux, uy)
                position[0], position[1], position[2] = px + rx, py + ry, pz + rz
                direction[0], direction[1] = (ux / speed, uy / speed) if speed > SLIP else (1.0, 0.0)
                load = point.expected(smooth=smooth) if self._pivoting else 0.0
                surface.mode, surface.mu = (
                    (bounded, self.friction * load) if load > 0.0 else (bounded | ode_library.APPROX_1, self.friction)
                )
                surface.mu2 = 0.0 if speed > SLIDES else surface.mu
                contact.geometry.depth = -(pz + rz)
                joint = ode.dJointCreateContact(self._world, self._group, self._pointer)
                ode.dJointAttach(joint, link.body, None)
                if self._pivoting:
                    ode.dJointSetFeedback(joint, ctypes.byref(point.load))

    def clear(self) -> None:
        """Take the contact joints away again."""
        ode.dJointGroupEmpty(self._group)

    def close(self) -> None:
        """Free the group."""
        ode.dJointGroupDestroy(self._group)
