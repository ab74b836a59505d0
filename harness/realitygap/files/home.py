"""`~` of a path on the command line, which shells leave alone in `--out=~/kick` and `NAME=~/meshes`."""

import os
from pathlib import Path


def at_home(text: str) -> Path:
    """The path that is meant, with a leading `~` as the home folder; that of an unknown user stays, as in a shell.

    Left to readers it leads elsewhere: pandas takes it for the home folder, where pathlib makes a folder called `~`.
    """
    return Path(os.path.expanduser(text))  # noqa: PTH111 - pathlib raises an error for an unknown user
