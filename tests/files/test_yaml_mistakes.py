"""A file that is no YAML: where the mistake is, and in plain words what it likely is."""

from pathlib import Path

import pytest
from realitygap.files.errors import InputError
from realitygap.files.yaml_file import load_yaml


@pytest.mark.parametrize(
    ("text", "where", "likely"),
    [
        ('robot:\n  urdf: "a"\n   base: fixed\n', "line 3, column 4, in `base: fixed`", "its indentation does not fit"),
        ("robot:\n  urdf: a\n   base: fixed\n", "line 3, column 8, in `base: fixed`", "its indentation does not fit"),
        ("robot:\n  urdf: a\n base: fixed\n", "line 3, column 2, in `base: fixed`", "its indentation does not fit"),
        ("- a\nname: b\n", "line 2, column 1, in `name: b`", "its indentation does not fit"),
        ("name: foo: bar\n", "line 1, column 10, in `name: foo: bar`", "holds `: `; expected such a value in quotes"),
        ("kp:100\nkd: 2\n", "line 2, column 3, in `kd: 2`", "expected `: ` with a space behind every key"),
        (
            "r:\n  urdf: a\n  base:fixed  # so\n\ns:\n",
            "line 3, column 3, in `base:fixed # so`",
            "no key with a value; expected `: `",
        ),
        ("r:\n  urdf: a\n  base\ns:\n", "line 3, column 3, in `base`", "no key with a value; expected `: `"),
        ('name: "a" b\n', 'line 1, column 11, in `name: "a" b`', "text stands behind a value in quotes"),
        ("joints: *\nkp: 1\n", "line 1, column 10, in `joints: *`", "begins with * or &; expected such a value in qu"),
        ("joints: *_knee\n", "line 1, column 9, in `joints: *_knee`", "begins with * or &"),
        ("window: [1, 2\nname: b\n", "line 2, column 5, in `name: b`", "what opens in line 1 is not closed"),
        ("name: a\nrobot: {\n", "line 2, column 9, in `robot: {`", "a bracket that opens is not closed"),
        ("a: ]\n", "line 1, column 4, in `a: ]`", "closes that none has opened"),
        ('name: "a\nrobot: b\n', 'line 1, column 7, in `name: "a`', "the quote that opens here is not closed"),
        ("robot:\n\turdf: a\n", "line 2, column 1, in `urdf: a`", "expected spaces in place of a tab"),
        ("name: @a\n", "line 1, column 7, in `name: @a`", "expected such a value in quotes"),
        ('path: "C:\\data"\n', "line 1, column 11, in ", "expected single quotes"),
    ],
)
def test_where_it_is_and_what_is_likely(tmp_path: Path, text: str, where: str, likely: str) -> None:
    path = tmp_path / "scenario.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_yaml(path)
    said = str(caught.value)
    assert said.startswith(f"{path}: is not valid YAML at {where}")
    assert likely in said
    assert "\n" not in said
    assert "block" not in said


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"\x0e\x0e(\xde\x19y", "no text in UTF-8, as line 1 shows; expected UTF-8: save it with this encoding"),
        ("name: a\n".encode("utf-16"), "text in UTF-16; expected UTF-8: save it with this encoding"),
        ("name: a\n# 5 °\n".encode("latin-1"), "no text in UTF-8, as line 2 shows; expected UTF-8"),
    ],
)
def test_what_is_no_text_in_utf_8_is_said_to_be_none(data: bytes, said: str, tmp_path: Path) -> None:
    path = tmp_path / "scenario.yaml"
    path.write_bytes(data)
    with pytest.raises(InputError) as caught:
        load_yaml(path)
    assert str(caught.value).startswith(f"{path}: is not valid YAML: {said}")


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_lines_end_as_any_editor_ends_them(end: str, tmp_path: Path) -> None:
    path = tmp_path / "scenario.yaml"
    path.write_bytes(f"name: a{end}base: fixed{end}".encode())
    assert load_yaml(path) == {"name": "a", "base": "fixed"}
