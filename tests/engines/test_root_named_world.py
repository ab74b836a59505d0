"""A URDF whose root link is called `world`, as many are, opens in every engine."""

import numpy as np
import pytest
import realitygap_engines as engines
from realitygap_engines import Physics
from realitygap_engines.model.robot import Joint, Link, Model


@pytest.mark.parametrize("engine", engines.available())
def test_a_root_named_world_opens(engine: str) -> None:
    arm = Link("arm", 1.0, np.array([0.0, 0.0, -0.1]), np.eye(3) * 1e-3)
    base = Link("world", 1.0, np.zeros(3), np.eye(3) * 1e-3)
    model = Model("m", (base, arm), (Joint("j", False, 0, np.eye(4), np.array([0.0, 1.0, 0.0])),), False)
    with engines.load(engine).open(model, Physics()) as simulation:
        simulation.step(np.array([0.1]), np.zeros(1), np.zeros(1))
        position, velocity = np.zeros(1), np.zeros(1)
        simulation.read(position, velocity, np.zeros(13))
    assert velocity[0] == pytest.approx(0.1 * 1e-3 / (1e-3 + 0.01), rel=1e-3)
