"""MuJoCo's own settings: what is switched off to save time changes nothing."""

import mujoco
import numpy as np
import pytest
from bench_overhead import case, humanoid, pendulum
from realitygap_engines import Physics
from realitygap_engines.model.robot import Model
from realitygap_engines.mujoco import MujocoSimulation


@pytest.mark.parametrize("model", [pendulum(), humanoid()], ids=lambda m: m.name)
def test_a_robot_moves_alike_with_islands(model: Model) -> None:
    served = case(model, 1.0, servo=True)
    n = len(model.joints)

    def moved(islands: bool) -> np.ndarray:
        simulation = MujocoSimulation(served.plant.machine(), Physics(1e-3, ground=served.plant.ground))
        if islands:
            simulation._m.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_ISLAND)
        simulation.reset(served.start())
        for k in range(400):
            simulation.step(np.full(n, 0.3 * np.sin(0.02 * k)), np.full(n, 0.02), np.full(n, 0.1))
        return np.concatenate([simulation._d.qpos, simulation._d.qvel])

    np.testing.assert_array_equal(moved(False), moved(True))


def test_its_clock_is_asked_before_and_after_our_simulations_only() -> None:
    model = mujoco.MjModel.from_xml_string("<mujoco><worldbody/></mujoco>")

    def timed() -> float:
        data = mujoco.MjData(model)
        mujoco.mj_step(model, data)
        return float(data.timer[mujoco.mjtTimer.mjTIMER_STEP].duration)

    assert timed() > 0.0
    first, second = (MujocoSimulation(pendulum(), Physics(1e-3)) for _ in range(2))
    assert timed() == 0.0
    first.close()
    assert timed() == 0.0
    second.close()
    assert timed() > 0.0
