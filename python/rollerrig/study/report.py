"""The blocks of a report and the page they make.

Page(title, sections of blocks) -> [jinja2 template] -> one self-contained HTML text
"""

from __future__ import annotations

import base64
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from importlib.resources import files

from jinja2 import Environment, StrictUndefined
from matplotlib.figure import Figure


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


@dataclass(frozen=True)
class Check:
    """A number that should have a value.

    Attributes:
        name: what is checked.
        value: what came out.
        expected: what it should be.
        tolerance: allowed deviation, in the unit of `deviation`.
        deviation: how far off it is: absolute, or relative where `relative` is set.
        unit: of value and expected.
        reason: why the tolerance is what it is.
        relative: whether deviation and tolerance are relative.
    """

    name: str
    value: float
    expected: float
    tolerance: float
    reason: str
    unit: str = ""
    relative: bool = False

    @property
    def deviation(self) -> float:
        """Distance from the expected value."""
        distance = abs(self.value - self.expected)
        if not self.relative:
            return distance
        return distance / abs(self.expected) if self.expected else math.inf

    @property
    def passed(self) -> bool:
        """Whether the deviation is within the tolerance."""
        return self.deviation <= self.tolerance

    def as_dict(self) -> dict[str, object]:
        """For summary.json."""
        return {**asdict(self), "deviation": self.deviation, "passed": self.passed}


Block = Text | Picture | Table | Preformatted


@dataclass
class Section:
    """A part of the report with a heading."""

    title: str
    blocks: list[Block] = field(default_factory=list)

    @property
    def anchor(self) -> str:
        """For links within the page."""
        return "".join(c if c.isalnum() else "-" for c in self.title.lower()).strip("-")


@dataclass
class Page:
    """A whole report."""

    title: str
    summary: str
    sections: list[Section]
    footer: str = ""


_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value: object, digits: int = 4) -> str:
    """A number as people write it; text as it is."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return str(value)
    if isinstance(value, int):
        return f"{value:,}".replace(",", "\u202f")
    if not math.isfinite(value):
        return "–"
    if value != 0 and not 1e-3 <= abs(value) < 1e6:
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
        power = f"10{str(int(exponent)).translate(_SUPERSCRIPT)}"
        return power if mantissa == "1" else f"{mantissa}·{power}"
    return f"{value:.{digits}g}" if abs(value) < 1e4 else f"{value:,.0f}".replace(",", "\u202f")


def percent(value: float | None, digits: int = 2, *, signed: bool = False) -> str:
    """A ratio as a percentage, a dash where there is none."""
    return "–" if value is None else f"{100 * value:{'+' if signed else ''}.{digits}g} %"


def check_table(checks: Sequence[Check]) -> Table:
    """The checks as a table, passed or failed."""
    rows = []
    for check in checks:
        scale, unit = (100.0, "%") if check.relative else (1.0, check.unit)
        rows.append(
            (
                "✔ pass" if check.passed else "✘ FAIL",
                check.name,
                f"{number(check.value)} {check.unit}".strip(),
                f"{number(check.expected)} {check.unit}".strip(),
                f"{number(scale * check.deviation, 3)} {unit}".strip(),
                f"{number(scale * check.tolerance, 3)} {unit}".strip(),
                check.reason,
            )
        )
    return Table(("", "check", "computed", "expected", "deviation", "tolerance", "why this tolerance"), rows)


def render(page: Page) -> str:
    """The report as HTML text."""
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters["number"] = number
    environment.tests["numeric"] = lambda cell: isinstance(cell, int | float) and not isinstance(cell, bool)
    template = files("rollerrig.study").joinpath("page.html.j2").read_text(encoding="utf-8")
    return environment.from_string(template).render(page=page)
