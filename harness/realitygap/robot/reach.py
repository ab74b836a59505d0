"""How large a robot is."""

import numpy as np
from realitygap_engines.model.robot import Link, Model


def reach(model: Model) -> float:
    """How far a robot reaches from its base, stretched out [m]: offsets of joints, centres of mass and contact."""
    far = np.zeros(len(model.links))
    for i, joint in enumerate(model.joints):
        far[i + 1] = far[joint.parent] + float(np.linalg.norm(joint.origin[:3, 3]))
    own = [
        max([float(np.linalg.norm(x.com)), *(float(np.linalg.norm(s.center)) + s.radius for s in x.spheres)])
        for x in model.links
    ]
    return float(np.max(far + np.array(own)))


def gyration(link: Link) -> float:
    """How far from its centre a link's mass lies, at most [m]: its largest radius of gyration."""
    return float(np.sqrt(np.linalg.eigvalsh(link.inertia)[-1] / link.mass)) if link.mass > 0.0 else 0.0
