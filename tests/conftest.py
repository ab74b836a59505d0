"""What all tests share: the folder of recordings that lies outside the repository."""

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """The folder that `REALITYGAP_DATA` names; a test that asks for it is skipped where there is none."""
    folder = os.environ.get("REALITYGAP_DATA")
    if not folder or not Path(folder).is_dir():
        pytest.skip("needs recordings from outside the repository: set REALITYGAP_DATA to their folder")
    return Path(folder).resolve()
