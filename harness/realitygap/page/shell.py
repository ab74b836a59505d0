"""The shell of every page: templates of a room with the common style, written as one file that opens offline."""

from importlib.resources import files
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

STYLES = ("page.css", "story.css")


def render(room: str, template: str, **content: Any) -> str:
    """The page that a template in the `web` folder of a room (`realitygap.report`) makes of this content.

    `css` is the common style; text is escaped unless it is `Markup`.
    """
    environment = Environment(
        loader=PackageLoader(room, "web"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template).render(css=style(), **content)


def style() -> Markup:
    """The common style sheets."""
    web = files("realitygap.page") / "web"
    return Markup("\n".join((web / sheet).read_text(encoding="utf-8") for sheet in STYLES))
