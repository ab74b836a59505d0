"""A joint that is held is the joint at rest at its angle: in the mass matrix, the bias and the contact points."""

from dataclasses import replace

import numpy as np
import pytest
import realitygap_engines as engines
import trees
from realitygap_engines import Physics, State
from realitygap_engines.model.hold import hold, own_body
from realitygap_engines.model.robot import Model, Sphere, link_poses


def tree(floating: bool) -> Model:
    """With a ball on every link, and the bodies' names."""
    model, rng = trees.tree([0, 1, 2, 2, 4], floating, seed=7), np.random.default_rng(7)
    balls = [(Sphere(rng.uniform(-0.1, 0.1, 3), 0.02),) for _ in model.links]
    links = (replace(x, spheres=b, merged=(x.name,)) for x, b in zip(model.links, balls, strict=True))
    return replace(model, links=tuple(links))


@pytest.mark.parametrize("name", engines.available())
@pytest.mark.parametrize("held", [{1: 0.4}, {0: -0.3, 3: 0.05}, {4: 1.0, 3: -0.02}])
def test_the_machine_is_that_with_the_joint_at_rest_there(name: str, held: dict[int, float]) -> None:
    full, rng = tree(False), np.random.default_rng(1)
    kept = [i for i in range(5) if i not in held]
    q, v = rng.uniform(-1, 1, 5), rng.uniform(-2, 2, 5)
    for i, angle in held.items():
        q[i], v[i] = angle, 0.0
    found = []
    for model, chosen in ((full, list(range(5))), (hold(full, held), kept)):
        with engines.load(name).open(model, Physics()) as simulation:
            simulation.reset(State(q[chosen], v[chosen]))
            found.append((simulation.mass_matrix(), simulation.bias()))
    (mass, bias), (short, left) = found
    np.testing.assert_allclose(short, mass[np.ix_(kept, kept)], rtol=0, atol=1e-8)
    np.testing.assert_allclose(left, bias[kept], rtol=0, atol=1e-6)


def test_contact_points_stay_where_they_are() -> None:
    full, held = tree(True), {1: 0.4, 3: -0.05}
    short = hold(full, held)
    q = np.array([0.3, 0.4, -0.2, -0.05, 0.7])

    def points(model: Model, position: np.ndarray) -> np.ndarray:
        poses = link_poses(model, position)
        found = [
            pose[:3, :3] @ s.center + pose[:3, 3]
            for link, pose in zip(model.links, poses, strict=True)
            for s in link.spheres
        ]
        return np.array(sorted(found, key=lambda p: p[0]))

    np.testing.assert_allclose(points(short, q[[0, 2, 4]]), points(full, q), atol=1e-12)
    assert short.mass == pytest.approx(full.mass)
    assert short.joint_names == ["joint0", "joint2", "joint4"]


def test_a_link_can_be_told_without_what_it_holds() -> None:
    """As a mended URDF needs it: also after the whole became heavier."""
    full = tree(False)
    whole = hold(full, {1: 0.4}).links[1]
    mass, com, inertia = own_body(whole)
    assert mass == pytest.approx(full.links[1].mass)
    np.testing.assert_allclose(com, full.links[1].com, atol=1e-12)
    np.testing.assert_allclose(inertia, full.links[1].inertia, atol=1e-12)
    assert own_body(replace(whole, mass=whole.mass + 0.5))[0] == pytest.approx(full.links[1].mass + 0.5)
