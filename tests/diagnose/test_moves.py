"""Steps of a fit and moves of the search, by themselves."""

from dataclasses import replace

import numpy as np
import pytest
from demo_problem import demo_problem, suspect_of
from realitygap.diagnose.candidates.starts import guess, starts
from realitygap.diagnose.candidates.suspects import LATER, bounds
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.demanded import demanded
from realitygap.diagnose.fit.fit import Fit, secant
from realitygap.diagnose.fit.responses import Block
from realitygap.diagnose.fit.space import Space
from realitygap.diagnose.likelihood.channel_blocks import ChannelBlocks
from realitygap.diagnose.likelihood.metric import Metric, marginalised
from realitygap.diagnose.likelihood.whitening import Channel, Whitening
from realitygap.diagnose.search.criterion import Criterion
from realitygap.diagnose.search.grow import with_shape
from realitygap.diagnose.search.linear import Linear, linear_at
from realitygap.diagnose.search.rivals import LOOSER
from realitygap_engines.model.robot import Sphere


def white(n: int) -> Metric:
    """The metric of samples whose noise has a standard deviation of one."""
    channel = Channel(0, "position", 0, 0.01 * np.arange(n, dtype=np.float64), 1.0, np.zeros(n))
    whitening = Whitening((channel,), np.zeros(1), np.ones(1))
    return marginalised(whitening, np.ones(n), ChannelBlocks.of(np.zeros((n, 0)), [n]), 0.0)


def test_slopes_tell_the_step_that_was_taken_and_what_lies_across_it_as_before() -> None:
    rng = np.random.default_rng(1)
    slopes, step, change = rng.standard_normal((30, 4)), rng.standard_normal(4), rng.standard_normal(30)
    told = slopes + secant(slopes, step, change)
    np.testing.assert_allclose(told @ step, change)
    across = rng.standard_normal(4)
    across -= step * (across @ step) / (step @ step)
    np.testing.assert_allclose(told @ across, slopes @ across)


@pytest.mark.parametrize("effect", ["command_profile", "effort_limit"])
def test_a_limit_beside_another_begins_at_several_sizes(effect: str) -> None:
    problem = demo_problem()
    whole = guess(problem, suspect_of(problem, effect, "elbow"))
    known, *others = LATER[effect]
    alone = replace(whole.at({n: np.inf for n in others if n != "share"}), free=(known,))
    tries = [with_shape(problem.plant, alone, looser) for looser in LOOSER]
    assert len(set(tries)) == len(LOOSER)
    for try_, looser in zip(tries, LOOSER, strict=True):
        assert set(try_.free) == set(LATER[effect])
        assert try_.parameters[known] == alone.parameters[known]
        new = [n for n in others if not np.isfinite(alone.parameters[n])]
        for name in new:
            assert try_.parameters[name] == pytest.approx(looser * tries[0].parameters[name] / LOOSER[0])
    assert with_shape(problem.plant, tries[0], LOOSER[-1]) == tries[0]


def test_what_is_tried_beside_a_plain_fit_gains_what_it_and_the_fit_leave_less() -> None:
    problem, rng = demo_problem(), np.random.default_rng(2)
    effects = ["viscous_friction", "coulomb_friction", "command_profile"]
    tried = [starts(problem, suspect_of(problem, e, "elbow"))[0] for e in effects]
    columns = rng.standard_normal((40, 3))
    left = -columns @ [1.0, 2.0, 1.0] + 0.01 * rng.standard_normal(40)
    blocks = [Block(start, columns[:, [k]]) for k, start in enumerate(tried)]
    lines = Linear(white(40), left, np.zeros((40, 0)), blocks)
    fixed = left + columns[:, 2]
    best, *_ = np.linalg.lstsq(columns[:, :2], -fixed, rcond=None)
    after = fixed + columns[:, :2] @ best
    assert lines.gain([0, 1], 2) == pytest.approx(0.5 * (left @ left - after @ after))
    assert lines.gain([0, 1]) < lines.gain([0, 1], 2)
    np.testing.assert_allclose([p.amounts[0] for p in lines.together([0, 1], 2)], best, rtol=1e-6)


def test_of_a_plain_fit_those_are_left_that_earn_it_beside_each_other() -> None:
    """Of two that do nearly the same the better one stays, though each gains alone; noise earns nothing."""
    problem, rng = demo_problem(), np.random.default_rng(7)
    effects = ["viscous_friction", "constant_effort", "controller_gain", "joint_offset"]
    tried = [starts(problem, suspect_of(problem, e, "elbow"))[0] for e in effects]
    columns = rng.standard_normal((400, 4))
    columns[:, 1] = columns[:, 0] + 0.3 * columns[:, 1]
    left = -columns @ [1.0, 0.0, 0.0, 0.7] + 0.5 * rng.standard_normal(400)
    blocks = [Block(start, columns[:, [k]]) for k, start in enumerate(tried)]
    lines = Linear(white(400), left, np.zeros((400, 0)), blocks)
    assert [k for k in range(4) if lines.gain_of(k).gain > 5.0] == [0, 1, 3]
    assert lines.earning(range(4), 5.0) == [0, 3]
    assert lines.earning([1, 2], 5.0) == [1]
    assert lines.earning([2], 5.0) == []


@pytest.mark.parametrize(("end", "most"), [("joint", 3.0), ("contact", 3.0), ("beyond", 12.0), ("nothing", 3.0)])
def test_a_link_has_no_more_inertia_than_with_its_mass_at_its_ends(end: str, most: float) -> None:
    """Of a rod m·L²/4 instead of m·L²/12, where a joint, a contact or nothing tells how long it is; (3·L)²/4 where a
    contact is a whole length beyond its end. Fits and straight lines keep to a quarter more, as laws are off.
    """
    problem, length = demo_problem(), 0.4
    (world, arm, *rest), (first, second) = problem.plant.model.links, problem.plant.model.joints
    inertia = np.diag([1.0, 1.0, 0.01]) * arm.mass * length**2 / 12
    contact = {"contact": length, "beyond": 1.5 * length}.get(end)
    spheres = () if contact is None else (Sphere(np.array([0.0, 0.0, -contact]), 0.01),)
    rod = replace(arm, com=np.array([0.0, 0.0, -length / 2]), inertia=inertia, spheres=spheres)
    origin = second.origin.copy()
    origin[:3, 3] = [0.0, 0.0, -length if end == "joint" else -length / 2]
    model = replace(problem.plant.model, links=(world, rod, *rest), joints=(first, replace(second, origin=origin)))
    there = replace(problem, plant=replace(problem.plant, model=model))
    suspect = suspect_of(there, "link_inertia", "upper_arm")
    low, high = bounds(there.plant, suspect)["scale"]
    assert high == pytest.approx(1.25 * most)
    assert 0.0 < low < 1.0
    assert Space(there, [guess(there, suspect)]).at(np.array([1e6]))[0].parameters["scale"] == high
    assert (found := starts(there, suspect)[0].at([1e6])).parameters["scale"] == high
    assert found.absurd(there.plant)
    assert not found.at({"scale": 0.99 * high}).absurd(there.plant)


@pytest.mark.parametrize(("place", "load"), [(0.3, True), (0.4, True), (0.5, False), (1.0, False), (-1.0, False)])
@pytest.mark.parametrize("stand", [0.0, 5.0])
def test_a_load_that_ran_away_from_its_link_is_none(place: float, load: bool, stand: float) -> None:
    """The forearm reaches 0.21 m and the arm 0.27, on whatever stand; a load is no further out than twice the first."""
    problem = demo_problem()
    first, *others = problem.plant.model.joints
    origin = first.origin.copy()
    origin[2, 3] += stand
    model = replace(problem.plant.model, joints=(replace(first, origin=origin), *others))
    problem = replace(problem, plant=replace(problem.plant, model=model))
    change = guess(problem, suspect_of(problem, "payload", "forearm"))
    assert change.at({"mass": 1.0, "x": 0.0, "y": place, "z": 0.1}).absurd(problem.plant) == (not load)


def test_a_load_lies_at_the_frame_of_its_link_along_an_axis_of_which_no_motion_tells() -> None:
    """Two parallel axes: it was begun with halfway to where it was tried along them."""
    problem = demo_problem()
    with Simulations(problem, 2) as simulations:
        criterion = Criterion(simulations, [])
        nothing = Fit((), demanded(simulations, (), criterion.train))
        blocks = criterion.responses(nothing, [suspect_of(problem, "payload", "forearm")])
    place = linear_at(criterion.plain(nothing), blocks).gain_of(0).change.parameters
    (silent,) = np.flatnonzero(problem.plant.model.joints[1].axis)
    tried = blocks[0].start.tries[1 + silent].parameters
    assert abs(place["xyz"[silent]]) < 0.01 * abs(tried["xyz"[silent]])


def test_of_what_answers_by_rounding_alone_no_amount_is_asked_for() -> None:
    """The mass of a load in a frame where axes meet: its place followed from whatever was made of that."""
    problem, rng = demo_problem(), np.random.default_rng(3)
    columns = 10.0 * rng.standard_normal((40, 4))
    columns[:, 0] *= 1e-9
    left = -columns @ [0.0, 0.4, 0.0, 0.2] + rng.standard_normal(40)
    blocks = [Block(starts(problem, suspect_of(problem, "payload", "forearm"))[0], columns)]
    amounts = Linear(white(40), left, np.zeros((40, 0)), blocks).gain_of(0).amounts
    np.testing.assert_allclose(amounts, [0.0, 0.4, 0.0, 0.2], atol=0.05)
