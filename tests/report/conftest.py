"""A page of invented results in a real browser, which tests of the page share."""

from collections.abc import Iterator
from pathlib import Path

import chromium
import invented_page
import pytest


@pytest.fixture(scope="session")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return invented_page.write(tmp_path_factory.mktemp("invented"))


@pytest.fixture(scope="session")
def shared() -> Iterator[chromium.Browser]:
    if chromium.PROGRAM is None:
        pytest.skip("needs Chromium: install it (Debian: apt install chromium)")
    with chromium.Browser() as browser:
        yield browser


@pytest.fixture
def browser(shared: chromium.Browser, page: Path) -> Iterator[chromium.Browser]:
    """The page, freshly opened; whatever it complains about fails the test."""
    shared.complaints.clear()
    shared.resize(1280, 900)
    shared.open(page)
    shared.wait("document.querySelector('#detail svg.plot') !== null")
    yield shared
    assert shared.complaints == []
