"""The errors have one root, come through from other processes, and are ValueErrors where input was wrong."""

import pickle

import pytest
from realitygap.files.errors import InputError
from realitygap_engines import Diverged, ModelError, RealityGapError, Unsupported

ERRORS = (InputError("a"), ModelError("b"), Unsupported("c"), Diverged(0.5, "knee", "too fast"))


@pytest.mark.parametrize("error", ERRORS, ids=lambda e: type(e).__name__)
def test_every_error_has_one_root_and_survives_a_process(error: RealityGapError) -> None:
    assert isinstance(error, RealityGapError)
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error)
    assert str(again) == str(error)
    assert vars(again) == vars(error)


def test_wrong_input_is_a_wrong_value() -> None:
    """Code that caught ValueError goes on to; what a simulation came to is not one."""
    assert [type(e) for e in ERRORS if isinstance(e, ValueError)] == [InputError, ModelError]
