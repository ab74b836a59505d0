"""How large a robot and its links are."""

import numpy as np
from realitygap_engines.model.robot import Link, Model


def reach(model: Model) -> float:
    """How far a robot reaches, stretched out [m], from its base, or from the first joint where the base stands still:
    offsets of joints, centres of mass and contact.
    """
    far = np.zeros(len(model.links))
    for i, joint in enumerate(model.joints):
        stands = joint.parent == 0 and not model.floating  # a stand of any height reaches nowhere
        far[i + 1] = 0.0 if stands else far[joint.parent] + float(np.linalg.norm(joint.origin[:3, 3]))
    moving = 0 if model.floating else 1
    own = [max(float(np.linalg.norm(x.com)), _contact(x)) for x in model.links]
    return float(np.max((far + np.array(own))[moving:], initial=0.0))


def extent(model: Model, index: int) -> float:
    """How far a link reaches from its own frame [m]: to the joints that it carries, to its contact, and to the end of a
    rod of even thickness with its centre of mass and its inertia, whose half length is √3 times its radius of gyration.
    """
    link = model.links[index]
    carried = [float(np.linalg.norm(j.origin[:3, 3])) for j in model.joints if j.parent == index]
    rod = float(np.linalg.norm(link.com)) + float(np.sqrt(3.0)) * gyration(link)
    return max([rod, _contact(link), *carried])


LIGHT = 100.0
"""kg/m³: no body of a robot is lighter than balsa wood; printed links and hollow ones of metal have 200 and more."""


def bulk(link: Link) -> float:
    """How large a link is at most [m]: the radius of a sphere of its mass, where it is as light as bodies come."""
    return float(np.cbrt(link.mass / LIGHT * 3.0 / (4.0 * np.pi)))


def _contact(link: Link) -> float:
    """How far from its frame a link touches, at most [m]."""
    return max((float(np.linalg.norm(s.center)) + s.radius for s in link.spheres), default=0.0)


def gyration(link: Link) -> float:
    """How far from its centre a link's mass lies, at most [m]: its largest radius of gyration."""
    return float(np.sqrt(np.linalg.eigvalsh(link.inertia)[-1] / link.mass)) if link.mass > 0.0 else 0.0
