"""The blocks of a report and the page they make.

Page(title, sections of blocks) -> [jinja2 template] -> one self-contained HTML text
"""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib.resources import files

from jinja2 import Environment, StrictUndefined
from matplotlib.figure import Figure

from rollerrig.wording import number


@dataclass(frozen=True)
class Text:
    """A paragraph of plain text."""

    text: str
    kind: str = "text"


@dataclass
class Picture:
    """A figure with its caption.

    Attributes:
        name: of its files.
        figure: to be drawn.
        caption: what it shows; also the alternative text.
        image: bytes of its SVG or PNG file, set when it is written.
    """

    name: str
    figure: Figure
    caption: str
    image: bytes = b""
    kind: str = "figure"

    @property
    def source(self) -> str:
        """The image as a data URI."""
        form = "png" if self.image.startswith(b"\x89PNG") else "svg+xml"
        return f"data:image/{form};base64,{base64.b64encode(self.image).decode()}"


@dataclass(frozen=True)
class Table:
    """A table; cells that are numbers are set to the right."""

    header: Sequence[str]
    rows: Sequence[Sequence[object]]
    caption: str = ""
    kind: str = "table"


@dataclass(frozen=True)
class Preformatted:
    """Text in fixed width, folded away until opened."""

    summary: str
    text: str
    kind: str = "preformatted"


Block = Text | Picture | Table | Preformatted


@dataclass
class Section:
    """A part of the report with a heading.

    Attributes:
        title: the heading.
        blocks: in their order.
        folded: whether it is a detail that the reader opens.
    """

    title: str
    blocks: list[Block] = field(default_factory=list)
    folded: bool = False

    @property
    def anchor(self) -> str:
        """For links within the page."""
        return "".join(c if c.isalnum() else "-" for c in self.title.lower()).strip("-")


@dataclass(frozen=True)
class Mark:
    """Said on every page, table, figure and file of a study whose numbers are not to be relied on.

    Attributes:
        name: one word, for files and summary.json.
        meaning: a sentence without its full stop.
    """

    name: str
    meaning: str

    @property
    def title(self) -> str:
        """The word as it stands on pages and figures."""
        return self.name.upper()


ANSWER_LINES = 5
"""So many findings stand at the top of a report; the others are opened by the reader."""

VIEW = "view.html"
"""The page beside a report that shows runs in motion."""


@dataclass
class Page:
    """A whole report.

    Attributes:
        title: of it.
        summary: the findings, a line each.
        sections: in their order.
        footer: who made it.
        mark: what is said on every page.
        view: what the page VIEW beside it shows in motion; "": there is none.
    """

    title: str
    summary: str
    sections: list[Section]
    footer: str = ""
    mark: Mark | None = None
    view: str = ""

    @property
    def answer(self) -> list[str]:
        """The findings that stand first."""
        return self.summary.splitlines()[:ANSWER_LINES]

    @property
    def further(self) -> list[str]:
        """The other findings, folded away."""
        return self.summary.splitlines()[ANSWER_LINES:]


def render(page: Page) -> str:
    """The report as HTML text."""
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters["number"] = number
    environment.tests["numeric"] = lambda cell: isinstance(cell, int | float) and not isinstance(cell, bool)
    template = files("rollerrig.study").joinpath("page.html.j2").read_text(encoding="utf-8")
    return environment.from_string(template).render(page=page, view=VIEW)
