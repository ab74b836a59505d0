"""A richer law begins where its special case was found, on the bundled demo (synthetic)."""

from demo_problem import demo_problem, suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.search.special_case import as_law


def test_a_law_begins_with_what_its_special_case_says() -> None:
    problem = demo_problem()
    dry = guess(problem, suspect_of(problem, "coulomb_friction", "elbow")).at({"torque": 0.3})
    sides, slow = (
        as_law(problem, dry, suspect_of(problem, e, "elbow")) for e in ("direction_friction", "stribeck_friction")
    )
    assert sides is not None
    assert slow is not None
    assert [sides.parameters[n] for n in ("forward", "backward")] == [0.3, 0.3]
    assert [slow.parameters[n] for n in ("static", "coulomb")] == [0.3, 0.3]
    assert slow.parameters["velocity"] > 0.0
    mass = guess(problem, suspect_of(problem, "link_mass", "forearm")).at({"mass": 0.3})
    assert as_law(problem, mass, suspect_of(problem, "payload", "forearm")) is None
