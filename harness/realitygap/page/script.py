"""Names in figures, in whatever script they are written."""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def any_script() -> Iterator[None]:
    """Inside, a figure is saved as SVG whose names may be in a script that matplotlib's own font does not have."""
    with warnings.catch_warnings():
        # text stays text there, and what shows the figure has a font for it: nothing is missing
        warnings.filterwarnings("ignore", r"Glyph \d+ .* missing from font", UserWarning)
        yield
