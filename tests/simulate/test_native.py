"""Steps in compiled code are the steps in Python, to the last bit."""

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import realitygap_engines as engines
from bench_overhead import case, humanoid
from realitygap.robot.effects import EFFECTS, Effect
from realitygap.robot.plant import Plant
from realitygap.simulate import effect_bench
from realitygap.simulate.effect_bench import bench, motion, planted
from realitygap.simulate.rollout import rollout
from realitygap.trace.trace import Trace
from realitygap_engines import Physics, Simulation
from signals import Signals

DURATION = 0.6


def offered(engine: str, plant: Plant) -> type[Simulation] | None:
    """The class of an engine's simulations where they can be stepped from compiled code."""
    with engines.load(engine).open(plant.machine(), Physics(ground=plant.ground)) as simulation:
        return None if simulation.native() is None else type(simulation)


NATIVE = [e for e in engines.available() if offered(e, effect_bench.arm())]


def test_some_engine_offers_it() -> None:
    assert "mujoco" in NATIVE


@pytest.mark.parametrize("engine", NATIVE)
@pytest.mark.parametrize("effect", EFFECTS.values(), ids=list(EFFECTS))
def test_the_traces_are_the_same_bit_for_bit(effect: Effect, engine: str, monkeypatch: pytest.MonkeyPatch) -> None:
    plant = planted(effect)

    def simulated() -> Trace:
        return effect_bench.simulate(plant, engine, motion(effect), duration=DURATION)

    compiled = simulated()
    slow = offered(engine, bench(effect)[0])
    assert slow is not None
    monkeypatch.setattr(slow, "native", lambda _: None)
    in_python = simulated()
    for signal in Trace.SIGNALS:
        ours, theirs = getattr(compiled, signal), getattr(in_python, signal)
        assert (ours is None) == (theirs is None)
        if ours is not None:
            np.testing.assert_array_equal(ours, theirs, err_msg=signal)


@pytest.mark.parametrize("engine", NATIVE)
def test_dry_friction_is_that_of_the_joints_that_have_any(engine: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """On a robot that falls onto its feet, whose contacts come and go beside friction in every other joint."""
    served = case(humanoid(), DURATION, servo=True)
    for name in ("coulomb", "static"):
        served.plant.drive[name][::2] = 0.0
    start = served.start()
    start.base_position[2] += 0.02

    def simulated() -> Trace:
        plant = served.plant
        with engines.load(engine).open(plant.machine(), Physics(1e-3, ground=plant.ground)) as simulation:
            return rollout(simulation, plant, served.commands(), start, DURATION, joint_effort=True).trace

    compiled = simulated()
    slow = offered(engine, served.plant)
    assert slow is not None
    monkeypatch.setattr(slow, "native", lambda _: None)
    in_python = simulated()
    np.testing.assert_array_equal(Signals(compiled).effort, Signals(in_python).effort)
    np.testing.assert_array_equal(Signals(compiled).position, Signals(in_python).position)


@pytest.mark.parametrize("engine", NATIVE)
def test_a_blow_up_is_located_alike(engine: str, monkeypatch: pytest.MonkeyPatch) -> None:
    told = []
    for compiled in (True, False):
        plant = effect_bench.arm()
        plant.drive["constant"] = 1e9
        if not compiled:
            slow = offered(engine, plant)
            assert slow is not None
            monkeypatch.setattr(slow, "native", lambda _: None)
        with pytest.raises(engines.Diverged) as error:
            effect_bench.simulate(plant, engine, duration=DURATION)
        told.append((error.value.time, error.value.joint))
    assert told[0] == told[1]
    assert math.isfinite(told[0][0])


@pytest.mark.parametrize("engine", NATIVE)
def test_simulations_in_threads_are_those_one_by_one(engine: str) -> None:
    plants = [effect_bench.arm() for _ in range(4)]
    for k, plant in enumerate(plants):
        plant.drive["viscous"] = 0.1 * k

    def simulated(plant: Plant) -> Trace:
        return effect_bench.simulate(plant, engine, duration=DURATION)

    one_by_one = [simulated(plant) for plant in plants]
    with ThreadPoolExecutor(2) as threads:
        for ours, theirs in zip(threads.map(simulated, plants), one_by_one, strict=True):
            np.testing.assert_array_equal(Signals(ours).position, Signals(theirs).position)
