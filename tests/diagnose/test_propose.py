"""Proposals: odds as in closed form, segments within limits, files that play what was designed."""

import json
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from one_joint import pendulum, wheel
from realitygap.diagnose.propose.condition import Condition
from realitygap.diagnose.propose.design import Answer, answer, chosen, separable, settling, sharpened, told
from realitygap.diagnose.propose.excitation import Excitation
from realitygap.diagnose.propose.explanations import Question
from realitygap.diagnose.propose.keyframes import EXACT, animation, waypoints
from realitygap.diagnose.propose.limits import MARGIN, Limits, as_recorded, limits_of
from realitygap.diagnose.propose.odds import Belief, expected
from realitygap.diagnose.propose.segments import Builder
from realitygap.diagnose.propose.told import origin_of
from realitygap.diagnose.propose.weak import _half
from realitygap.diagnose.propose.words import OPEN, one_sided
from realitygap.diagnose.propose.words import expected as odds_told
from realitygap.diagnose.propose.words import now as odds_now
from realitygap.files.errors import InputError
from realitygap.robot.drive import Array
from realitygap.scenario.propose import ProposeSpec, SegmentKind
from realitygap.simulate.motion import TICK, first_goals, play, read_animation
from realitygap.trace.trajectory import TOPIC, write_trajectory

KINDS: tuple[SegmentKind, ...] = ("hold", "triangle", "step", "chirp", "multisine", "reversal", "release")


def two_beliefs(random: np.random.Generator, samples: int = 30) -> tuple[Array, Belief, Belief]:
    """Two linear explanations, with two and three values: columns (samples, 2 + 2 + 3)."""
    columns = random.standard_normal((samples, 7))
    a, b = np.zeros((7, 2)), np.zeros((7, 3))
    a[2:4], b[4:] = np.eye(2), np.eye(3)
    one, two = np.eye(7)[0], np.eye(7)[1]
    precisions = [(lambda x: x @ x.T + 0.1 * np.eye(len(x)))(random.standard_normal((n, n + 2))) for n in (2, 3)]
    return columns, Belief(one, a, precisions[0]), Belief(two, b, precisions[1])


@pytest.mark.parametrize("seed", range(5))
def test_expected_odds_are_the_divergence_of_two_normal_predictions(seed: int) -> None:
    """By inner products alone the same as with the whole covariances (Kullback & Leibler 1951)."""
    columns, a, b = two_beliefs(np.random.default_rng(seed))
    means = [columns @ x.mean for x in (a, b)]
    here, there = (np.eye(len(columns)) + columns @ x.ways @ x.covariance @ (columns @ x.ways).T for x in (a, b))
    apart = means[0] - means[1]
    inverse = np.linalg.inv(there)
    told = np.trace(inverse @ here) - len(apart) + apart @ inverse @ apart
    told += np.linalg.slogdet(there)[1] - np.linalg.slogdet(here)[1]
    assert expected(columns.T @ columns, a, b) == pytest.approx(0.5 * told, rel=1e-9)


def test_where_the_true_values_are_known_the_distance_is_that_after_a_real_refit() -> None:
    """The rival's values move as far as old and new recordings let them: least squares on both."""
    columns, a, b = two_beliefs(np.random.default_rng(7))
    known = Belief(a.mean, np.zeros((7, 0)), np.zeros((0, 0)))
    ways, apart = columns @ b.ways, columns @ (a.mean - b.mean)
    root = np.linalg.cholesky(b.precision).T
    values = np.linalg.lstsq(np.vstack([ways, root]), np.concatenate([apart, np.zeros(3)]), rcond=None)[0]
    refitted = float(np.sum((apart - ways @ values) ** 2) + np.sum((root @ values) ** 2))
    gained = np.linalg.slogdet(b.precision + ways.T @ ways)[1] - np.linalg.slogdet(b.precision)[1]
    spread = np.trace(np.linalg.solve(b.precision + ways.T @ ways, ways.T @ ways))
    assert expected(columns.T @ columns, known, b) == pytest.approx(0.5 * (refitted + gained - spread), rel=1e-9)


def test_explanations_that_predict_the_same_stay_open_and_are_known_as_such() -> None:
    columns, a, _ = two_beliefs(np.random.default_rng(1))
    columns[:, 1], columns[:, 4:6], columns[:, 6] = columns[:, 0], columns[:, 2:4], 0.0
    twin = Belief(np.eye(7)[1], np.vstack([np.zeros((4, 2)), np.eye(2), np.zeros((1, 2))]), a.precision)
    question = Question(0, 1, ("one", "other"), (), 0.5)
    gram = columns.T @ columns
    assert expected(gram, a, twin) == pytest.approx(0.0, abs=1e-9)
    assert separable([question], [gram], [a, twin]) == []


def test_what_does_all_that_the_other_one_does_can_only_be_shown_itself() -> None:
    """Odds of being simpler are no odds of what is seen: they move nothing, and settle nothing."""
    question = Question(0, 1, ("offset", "center of mass"), (), 1.0)
    both, one, none = Answer(4.0, 30.0), Answer(4.0, 30.0, (True, False)), Answer(4.0, 30.0, (True, True))
    assert (both.least, one.least) == (4.0, 30.0)
    assert [a.shows(question) for a in (both, one, none)] == ["", "center of mass", ""]
    assert [a.moves(question) for a in (both, one, none)] == [True, True, False]
    assert not Answer(4.0, -1.0, (True, False)).moves(question)
    assert "center of mass" in one_sided(question, one)
    assert one_sided(question, both) == ""
    assert odds_told(question, none) == odds_told(question, Answer(0.5, -2.0)) == OPEN


def test_odds_now_are_those_of_the_side_that_is_named_first() -> None:
    """A question that leans to its second side says so: a page told it the other way round."""
    for leaning, said in ((1.0, "2.7 : 1"), (-1.0, "1 : 2.7")):
        assert odds_now(Question(0, 1, ("coulomb friction at elbow", "backlash at elbow"), (), leaning)) == said


def test_what_tells_most_in_its_time_is_chosen_and_the_worst_question_counts() -> None:
    """Three explanations without values: each segment tells two of them apart."""
    beliefs = [Belief(np.eye(3)[k], np.zeros((3, 0)), np.zeros((0, 0))) for k in range(3)]
    questions = [Question(0, 1, ("a", "b"), (), 0.0), Question(0, 2, ("a", "c"), (), 0.0)]

    def gram(b: float, c: float) -> Array:
        x = np.diag([0.0, b, c]) ** 0.5
        return np.asarray(x.T @ x)

    grams = [gram(8.0, 0.0), gram(0.0, 8.0), gram(1.0, 1.0), gram(16.0, 0.0)]
    goal = settling(questions, beliefs, [(grams, [4.0] * 4)], 8.0)
    picked = chosen(goal, grams, [4.0, 4.0, 4.0, 4.0], 8.0)
    assert set(picked) == {1, 3}
    assert answer(questions[1], grams[1], beliefs).least == pytest.approx(4.0)
    assert chosen(goal, grams, [4.0] * 4, 3.0) == []
    assert chosen(goal, [], [], 3.0) == []


def test_of_explanations_that_hardly_part_what_little_can_be_had_counts_no_more_than_what_much_there_is_of_others() -> (
    None
):
    """One segment tells all there is of a pair that hardly parts, another much of a pair that parts well."""
    beliefs = [Belief(np.eye(3)[k], np.zeros((3, 0)), np.zeros((0, 0))) for k in range(3)]
    questions = [Question(0, 1, ("a", "b"), (), 0.0), Question(0, 2, ("a", "c"), (), 0.0)]
    grams = [np.diag([0.0, *x]) for x in ((1.0, 0.0), (0.9, 9.0), (0.0, 10.0))]
    goal = settling(questions, beliefs, [(grams, [4.0] * 3)], 4.0)
    assert goal.most == pytest.approx(told(np.array([0.5, 5.0])))
    assert goal(np.array(grams))[[0, 2]] == pytest.approx(0.025)
    assert goal(grams[1]) == pytest.approx(1.05 * 0.9, rel=0.01)
    assert chosen(goal, grams, [4.0] * 3, 4.0) == [1]


def test_an_interval_shrinks_as_with_the_root_of_the_time_until_laws_themselves_are_in_doubt() -> None:
    """One value that a motion shows, alone and beside a law that may be off in the same way (closed forms)."""
    alone = Belief(np.zeros(1), np.eye(1), np.eye(1))
    assert sharpened(alone, 1, np.array([[3.0]]))[0] == pytest.approx(2.0)
    assert _half(alone, np.array([[1.0]]), 0, 1.0, 10.0) == pytest.approx(30.0)
    both = Belief(np.zeros(1), np.ones((1, 2)), np.eye(2))  # their sum is seen, neither of them alone
    assert sharpened(both, 1, np.array([[1e9]]))[0] == pytest.approx(2**0.5)
    assert _half(both, np.array([[1.0]]), 0, 1.0, 10.0) == np.inf


bounded = st.floats(0.2, 3.0)


@settings(max_examples=60, deadline=None)
@given(st.floats(-1.0, 1.0), bounded, bounded, st.floats(0.5, 12.0), st.sampled_from([0.002, 0.005, 0.01]))
def test_segments_start_and_end_at_rest_in_the_pose_and_ask_for_nothing_out_of_reach(
    home: float, down: float, up: float, fast: float, period: float
) -> None:
    limits = Limits(*(np.array([x]) for x in (home - down, home + up, fast, np.inf)))
    for segment in Builder(np.ones(1), np.array([home]), limits, period).every(KINDS):
        way = segment.value[:, 0]
        assert way[-1] == pytest.approx(home)
        assert np.ptp(way[-int(0.35 / period) :]) < 1e-9
        assert segment.enabled[-1]
        assert way.min() >= home - down
        assert way.max() <= home + up
        if segment.kind not in ("step", "release"):
            assert np.abs(np.diff(way, prepend=home)).max() / period <= fast * (1 + 1e-9)


def test_limits_are_the_narrowest_of_file_recordings_and_owner() -> None:
    model = pendulum().model
    free = limits_of(model, ProposeSpec(), np.array([[-0.5], [0.5]]), np.array([2.0]))
    assert free.lower[0] == pytest.approx(-0.6)
    assert free.speed[0] == pytest.approx(2.5)
    spec = ProposeSpec.model_validate({"limits": {"joint*": {"position": [-0.2, 0.9], "speed": 1.0, "effort": 3.0}}})
    own = limits_of(model, spec, np.array([[-0.5], [0.5]]), np.array([2.0]))
    assert [own.lower[0], own.upper[0], own.speed[0], own.effort[0]] == [-0.2, 0.9, 1.0, 3.0]
    with pytest.raises(InputError, match=r"propose.limits: nothing says how far and how fast joint0 may go"):
        limits_of(wheel().model, ProposeSpec(), None, None)
    assert 0 < MARGIN < 0.5
    partly = ProposeSpec.model_validate({"limits": {"joint0": {"effort": 3.0}, "*": {"position": [0, 1], "speed": 1}}})
    assert [as_recorded(model, s) for s in (ProposeSpec(), spec, partly)] == [["joint0"], [], ["joint0"]]


@pytest.mark.parametrize("kind", KINDS)
def test_keyframes_play_the_motion_and_a_trajectory_is_written_whole(kind: SegmentKind, tmp_path: Path) -> None:
    from rosbags.highlevel import AnyReader

    plant = pendulum()
    limits = Limits(*(np.array([x]) for x in (-1.2, 1.0, 5.0, np.inf)))
    segments = Builder(np.ones(1), np.array([0.1]), limits, 0.005).every([kind])
    scenario: Condition = Condition("", {}, None, plant)
    motion = Excitation("move", tuple(segments[:2]), scenario, 0.005)
    path = tmp_path / "move.json"
    path.write_text(json.dumps(animation(motion, plant.model)), encoding="utf-8")
    moves = read_animation(path)
    commands, length = play(path, moves, plant.model, first_goals(path, moves, plant.model))
    lead = commands.time[1] - commands.time[0]  # the first keyframe takes a moment
    assert length == pytest.approx(motion.seconds + lead, abs=TICK)
    told = motion.value[:, 0]
    on = np.isfinite(told)
    played = np.interp(motion.time + lead, commands.time, np.nan_to_num(commands.value[:, 0]))
    value = motion.path[:, 0]
    assert value[0] == value[-1] == pytest.approx(0.1)
    jump = np.abs(np.diff(value, prepend=value[0])) > 0.03
    near = np.convolve(jump | ~on, np.ones(7), mode="same") > 0  # a jump takes a tick, as does a switch
    firm = on & ~near
    assert firm.mean() > 0.4
    bent = np.abs(np.diff(value, n=2, prepend=value[:1], append=value[-1:]))[firm].max()  # within a tick
    assert np.abs(played - told)[firm].max() <= EXACT + bent + 1e-5
    off = np.diff(commands.time)[np.isnan(commands.value[1:, 0]) & np.isnan(commands.value[:-1, 0])].sum()
    assert off == pytest.approx(0.005 * np.sum(~on), abs=0.03)
    time, position, _ = waypoints(motion)
    write_trajectory(tmp_path / "move.mcap", ["joint0"], time, position)
    with AnyReader([tmp_path / "move.mcap"]) as reader:
        (connection,) = reader.connections
        assert connection.topic == TOPIC
        (message,) = [cast("Any", reader.deserialize(raw, c.msgtype)) for c, _, raw in reader.messages()]
    after = np.array([p.time_from_start.sec + 1e-9 * p.time_from_start.nanosec for p in message.points])
    np.testing.assert_allclose(after, time, atol=1e-8)
    np.testing.assert_allclose([p.positions[0] for p in message.points], position[:, 0])


def test_what_is_no_diagnosis_and_what_has_lost_its_scenario_are_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"holds no diagnosis.json; expected a scenario file or the folder"):
        origin_of(tmp_path)
    file = tmp_path / "diagnosis.json"
    for content in ("{", "[]", '{"findings": 3}', '{"scenario_file": 1, "engines": [], "findings": []}'):
        file.write_text(content, encoding="utf-8")
        with pytest.raises(InputError, match="is no diagnosis that names its scenario"):
            origin_of(tmp_path)
    file.write_text('{"schema": 99, "scenario_file": "a", "engines": ["mujoco"], "findings": []}', encoding="utf-8")
    with pytest.raises(InputError, match=r"diagnosis.json: schema: found 99; expected 1: diagnose it again"):
        origin_of(file)
    file.write_text('{"scenario_file": "gone.yaml", "engines": ["mujoco"], "findings": []}', encoding="utf-8")
    with pytest.raises(InputError, match=r"scenario_file: gone.yaml does not exist"):
        origin_of(file)
    assert origin_of(tmp_path / "scenario.yaml").findings is None
