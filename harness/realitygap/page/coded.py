"""Words of a scenario in our sentences stand between backticks, for terminals; on a page they are code."""

import re

PART = re.compile(r"<(script|style|title|svg|pre)\b.*?</\1>|<[^>]*>|`([^`<>]+)`", re.DOTALL)
"""What is left as it is, tags with their attributes among it, or words between backticks."""


def with_code(page: str) -> str:
    """The page with what stands between backticks in its text as `<code>`."""
    return PART.sub(lambda part: f"<code>{part[2]}</code>" if part[2] else part[0], page)
