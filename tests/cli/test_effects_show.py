"""The pages that a person reads about effects."""

from pathlib import Path

import numpy as np
import pytest
from realitygap.cli import effects_page as show
from realitygap.files.errors import InputError
from realitygap.robot.effects import EFFECTS


def test_the_table_lists_every_effect_once() -> None:
    lines = show.table().splitlines()
    assert [line.split()[0] for line in lines[1 : 1 + len(EFFECTS)]] == list(EFFECTS)


@pytest.mark.parametrize("name", EFFECTS)
def test_a_page_has_physics_equation_parameters_and_a_plot(name: str) -> None:
    text, effect = show.page(name), EFFECTS[name]
    assert " ".join(effect.page.equation.split()) in " ".join(text.split())
    assert " ".join(effect.page.confused_with.split()) in " ".join(text.split())
    for parameter in effect.parameters:
        assert parameter.name in text
    plot = [c for c in text if 0x2800 < ord(c) <= 0x28FF]
    assert len(plot) > 40
    assert max(len(line) for line in text.splitlines()) <= 120


def test_a_plot_shows_the_curve() -> None:
    x = np.linspace(0.0, 1.0, 50)
    rows = show.braille(x, x, columns=10, rows=4).splitlines()
    assert rows[0].startswith("1 ")
    assert rows[3].startswith("0 ")
    filled = [[c != chr(0x2800) for c in row[-10:]] for row in rows[:4]]
    assert filled[0][-1]
    assert not filled[0][0]
    assert filled[3][0]


def test_a_figure_is_written(tmp_path: Path) -> None:
    show.save_figure("backlash", tmp_path / "backlash.png")
    assert (tmp_path / "backlash.png").read_bytes().startswith(b"\x89PNG")


def test_an_unknown_effect_lists_those_there_are() -> None:
    with pytest.raises(InputError, match="coulomb_friction"):
        show.page("stiction")
