"""What is wrong with a file that is no YAML, in the words of a person who writes one: where, and what is likely."""

import yaml
from realitygap_engines.errors import in_a_line

LONGEST = 60
"""Characters of a line that a sentence has room for."""
SPACES = "expected spaces in place of a tab"
INDENTED = "its indentation does not fit the lines above; expected keys of one section one below the other"
NO_COLON = "the line above is no key with a value; expected `: ` with a space behind every key"
KEY = "it is no key with a value; expected `: ` with a space behind every key"
COLON = "its value holds `: `; expected such a value in quotes"
BEHIND = "text stands behind a value in quotes; expected the quotes around all of it"
BRACKET = "what opens in line {line} is not closed; expected a comma between values and a closing bracket"
OPEN = "a bracket that opens is not closed; expected a closing bracket, or a value behind the last key"
CLOSED = "a bracket closes that none has opened"
QUOTE = "the quote that opens here is not closed"
STAR = "its value begins with * or &; expected such a value in quotes"
BEGINS = "its value begins with a character that YAML keeps for itself; expected such a value in quotes"
BACKSLASH = "a backslash in double quotes begins a special character; expected single quotes around such a value"

KEYLESS = "could not find expected ':'"
BEGUN = ("end of stream", KEYLESS)
"""Problems that are seen behind the mistake, which is where what is not ended begins."""


def yaml_mistake(text: str, error: yaml.MarkedYAMLError) -> str:
    """The end of a sentence: the line and column, the line's text, and what is likely wrong there."""
    lines, problem = text.splitlines(), str(error.problem)
    mark = error.problem_mark or error.context_mark
    if mark is None:
        return f": {in_a_line(problem)}"
    if isinstance(error, yaml.constructor.ConstructorError):  # well-formed, and its sentence is our own
        return f" at line {mark.line + 1}: {problem}"
    if any(words in problem for words in BEGUN) and error.context_mark is not None:
        mark = error.context_mark
    number = min(mark.line, max(len(lines) - 1, 0))  # the end of the file is behind its last line
    line = lines[number] if lines else ""
    column = mark.column if number == mark.line else len(line)
    likely = _likely(problem, line, column, lines[:number]).format(
        line=error.context_mark and error.context_mark.line + 1
    )
    shown = in_a_line(line.strip(), LONGEST)
    return f" at line {number + 1}, column {column + 1}, in `{shown}`: {likely}"


def _likely(problem: str, line: str, column: int, above: list[str]) -> str:
    begins = not line[:column].strip() or line[:column].strip() == "-"  # what was found is the first of its line
    if problem.startswith("mapping values"):
        before = line[:column]
        if ": " in before:
            return COLON
        indents = [len(other) - len(other.lstrip()) for other in above if other.strip()]
        return INDENTED if indents and len(line) - len(line.lstrip()) > indents[-1] else NO_COLON
    if problem.startswith("expected <block end>"):
        return INDENTED if begins else BEHIND
    for words, likely in (
        ("'\\t'", SPACES),
        (KEYLESS, KEY),
        ("end of stream", QUOTE),
        ("expected ',' or", BRACKET),
        ("<stream end>", OPEN),
        ("expected the node content", CLOSED),
        ("alphabetic or numeric", STAR),
        ("undefined alias", STAR),
        ("cannot start any token", BEGINS),
        ("unknown escape", BACKSLASH),
    ):
        if words in problem:
            return likely
    return in_a_line(problem)
