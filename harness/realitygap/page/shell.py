"""The shell of every page: a room's template inside the common frame and style, as one file that opens offline."""

from importlib.resources import files
from typing import Any

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from realitygap.page.cards import with_column_names
from realitygap.page.coded import with_code

PAGE = "realitygap.page"
STYLES = ("page.css", "story.css")


def render(room: str, template: str, *, title: str, **content: Any) -> str:
    """The page that a template in the `web` folder of a room makes of this content; text is escaped unless `Markup`.

    Args:
        room: the package of the template, as `realitygap.report`.
        template: its file, which extends `shell.html.j2`.
        title: what the page is about.
        content: whatever else the template names.
    """
    environment = Environment(
        loader=ChoiceLoader([PackageLoader(room, "web"), PackageLoader(PAGE, "web")]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return with_code(with_column_names(environment.get_template(template).render(css=style(), title=title, **content)))


def style() -> Markup:
    """The common style sheets."""
    web = files(PAGE) / "web"
    return Markup("\n".join((web / sheet).read_text(encoding="utf-8") for sheet in STYLES))
