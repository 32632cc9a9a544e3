"""The blocks of a report and the page they make.

Page(title, sections of blocks) -> [jinja2 template] -> one self-contained HTML text
"""

import base64
import json
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib.resources import files

from jinja2 import Environment, StrictUndefined
from matplotlib.figure import Figure

from rollerrig.common.formatting import number
from rollerrig.study.charts import Chart
from rollerrig.viewer.page import ALLOWED, bundle

LONG_CELL = 40
"""Letters of a cell that is no longer one of a table of figures."""


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
        chart: its curves, in place of the image on a screen; likewise.
    """

    name: str
    figure: Figure
    caption: str
    image: bytes = b""
    chart: Chart | None = None
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

    @property
    def of_numbers(self) -> list[bool]:
        """Whether a column has nothing but numbers, and dashes in place of some."""
        columns = [[row[k] for row in self.rows if row[k] != "–"] for k in range(len(self.header))]
        return [bool(column) and all(map(_is_number, column)) for column in columns]

    @property
    def of_sentences(self) -> bool:
        """Whether cells are so long that on a narrow screen each row stands as a list."""
        return any(isinstance(cell, str) and len(cell) > LONG_CELL for row in self.rows for cell in row)


@dataclass(frozen=True)
class Preformatted:
    """Text in fixed width, folded away until opened."""

    summary: str
    text: str
    kind: str = "preformatted"


Block = Text | Picture | Table | Preformatted


@dataclass
class Section:
    """A part of the report with a heading; where folded, a detail that the reader opens."""

    title: str
    blocks: list[Block] = field(default_factory=list)
    folded: bool = False

    @property
    def anchor(self) -> str:
        """Anchor for links within the page."""
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


VIEW = "view.html"
"""The page beside a report that shows runs in motion."""


@dataclass
class Page:
    """A whole report: findings, a line each, sections, what VIEW beside it shows in motion ("": there is none).

    `refined`: the browser loads it again, as the command writes it again.
    """

    title: str
    summary: str
    sections: list[Section]
    footer: str = ""
    mark: Mark | None = None
    view: str = ""
    refined: bool = False

    @property
    def pictures(self) -> list[Picture]:
        """All of them."""
        return [block for section in self.sections for block in section.blocks if isinstance(block, Picture)]

    @property
    def charts(self) -> list[Chart]:
        """Those that can be zoomed."""
        return [picture.chart for picture in self.pictures if picture.chart is not None]

    @property
    def chart_heads(self) -> str:
        """What the page's program reads of them, as JSON."""
        heads = json.dumps([chart.head for chart in self.charts], ensure_ascii=False, separators=(",", ":"))
        return heads.replace("<", "\\u003c")


_NUMBER = re.compile("[-+]?[0-9][0-9. \u202f]*(·10)?[⁻⁰¹²³⁴-⁹]*( %)?")


def _is_number(cell: object) -> bool:
    """Whether a cell is a number, or the text of one."""
    if isinstance(cell, str):
        return _NUMBER.fullmatch(cell) is not None
    return isinstance(cell, int | float) and not isinstance(cell, bool)


def render(page: Page) -> str:
    """The report as HTML text."""
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters["number"] = number
    template = files("rollerrig.study").joinpath("page.html.j2").read_text(encoding="utf-8")
    return environment.from_string(template).render(page=page, view=VIEW, bundle=bundle, allowed=ALLOWED)
