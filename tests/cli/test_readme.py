"""What the documents say can be typed: commands parse, targets and files exist."""

import pkgutil
import re
import shlex
from pathlib import Path

import pytest
from realitygap.cli.main import app
from realitygap.compare.row import COLUMNS
from typer.main import get_command

ROOT = Path(__file__).parents[2]
DOCUMENTS = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "scenarios/README.md")


def text(document: str) -> str:
    return (ROOT / document).read_text(encoding="utf-8")


def commands(document: str) -> list[str]:
    """Every `realitygap ...` in a code block or between backticks, without its comment."""
    page = text(document)
    blocks = [
        line
        for block in re.findall(r"^```\w*\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
        for line in block.splitlines()
    ]
    inline = re.findall(r"(?<!`)`([^`\n]+)`", page)
    found = [
        re.match(r"(?:\.venv/bin/)?realitygap( .*)?$", part.partition("  #")[0].strip()) for part in [*blocks, *inline]
    ]
    return [match[1] or "" for match in found if match]


EVERY = [(document, command) for document in DOCUMENTS for command in commands(document)]


def test_the_documents_name_commands() -> None:
    named = {command.split()[0] for _, command in EVERY if command}
    assert named == set(get_command(app).commands)  # type: ignore[attr-defined]


@pytest.mark.parametrize(("document", "command"), EVERY)
def test_every_command_can_be_typed(document: str, command: str) -> None:
    """It parses, with every argument and option that it needs, or is a command's bare name; nothing is run."""
    level = get_command(app)
    words = shlex.split(command)
    while words and hasattr(level, "commands"):
        name = words.pop(0)
        assert name in level.commands, f"{document}: realitygap {command}"
        level = level.commands[name]
    if words:
        level.make_context(document, words)


def test_links_lead_to_files() -> None:
    for document in DOCUMENTS:
        for link in re.findall(r"\]\(([^)#:]+)\)", text(document)):
            assert (ROOT / document).parent.joinpath(link).exists(), f"{document}: {link}"


def test_places_in_this_repository_exist() -> None:
    for document in ("README.md", "CONTRIBUTING.md"):
        for path in re.findall(r"[` ]((?:engines|harness|tests|scenarios|results)/[\w./]+)", text(document)):
            made_up = "NAME" in path or "__pycache__" in path or path.startswith(("scenarios/kick", "results/runs"))
            assert made_up or (ROOT / path).exists(), f"{document}: {path}"
        for module in re.findall(r"`(realitygap(?:_engines)?(?:\.\w+)*)`", text(document)):
            pkgutil.resolve_name(module)


def test_the_paths_of_bundled_scenarios_exist() -> None:
    for path in re.findall(r"scenarios/(?:demo|sigmaban)\S*\.yaml", text("README.md") + text("Makefile")):
        assert (ROOT / path).is_file(), path


def test_names_are_those_of_the_files() -> None:
    """Outcomes and keys that the README explains are those that are written."""
    readme = text("README.md")
    assert {"joint", "signal", "engine", "recording"} <= set(COLUMNS)
    for key in ("verdict", "where", "findings", "cannot_tell_from", "experiment", "worsened"):
        assert f"**{key}**" in readme
