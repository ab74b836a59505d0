"""Contact of the model's spheres with the plane z = 0 as contact joints of ODE, made anew for every step.

ODE's own sphere and plane give the same one point, at the sphere's surface, with the same depth; calling its collision
detection back from Python would cost more than the step. ERP = h k/(h k + d) and CFM = 1/(h k + d) are Gazebo's mapping
of stiffness k and damping d: the force of the spring and damper at the end of the step. A point that slides has the
cone's friction, against its slip and none across it: across it, friction would hold the point where an impact turns the
body, with 1.4 times the cone's force. One that creeps or rests has a pyramid and holds up to 1.4 times as much askew.
"""

import ctypes
from collections.abc import Sequence
from math import hypot

from engines import ode_library
from engines.engine import Physics
from engines.model import Model
from engines.ode_library import Contact
from engines.ode_robot import OdeLink, ode

LAYER = 1e-5
"""Depth of rigid contacts that is not corrected [m], so that they do not come and go."""
SLIP = 1e-6
"""A contact point that is slower has no direction of slip [m/s]."""
SLIDES = 0.01
"""A contact point that is slower may come to rest within a step, and is held in every direction [m/s]."""


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
            spheres = [(*(s.center - link.com).tolist(), s.radius) for s in link.spheres if i or model.floating]
            if spheres:
                reach = max(hypot(x, y, z) + radius for x, y, z, radius in spheres)
                self._feet.append((part, spheres, reach))

    def make(self) -> None:
        """Make a contact joint for every sphere that touches the plane now."""
        contact, position, direction = self._contact, self._contact.geometry.position, self._contact.direction
        for link, spheres, reach in self._feet:
            px, py, pz = link.position.tolist()
            if pz > reach:
                continue
            a, b, c, _, d, e, f, _, g, h, i, _ = link.rotation.tolist()
            vx, vy, _ = link.linear.tolist()
            wx, wy, wz = link.angular.tolist()
            for x, y, z, radius in spheres:
                rz = g * x + h * y + i * z - radius
                if pz + rz > 0.0:
                    continue
                rx, ry = a * x + b * y + c * z, d * x + e * y + f * z
                ux, uy = vx + wy * rz - wz * ry, vy + wz * rx - wx * rz
                speed = hypot(ux, uy)
                position[0], position[1], position[2] = px + rx, py + ry, pz + rz
                direction[0], direction[1] = (ux / speed, uy / speed) if speed > SLIP else (1.0, 0.0)
                contact.surface.mu2 = 0.0 if speed > SLIDES else self.friction
                contact.geometry.depth = -(pz + rz)
                ode.dJointAttach(ode.dJointCreateContact(self._world, self._group, self._pointer), link.body, None)

    def clear(self) -> None:
        """Take the contact joints away again."""
        ode.dJointGroupEmpty(self._group)

    def close(self) -> None:
        """Free the group."""
        ode.dJointGroupDestroy(self._group)
