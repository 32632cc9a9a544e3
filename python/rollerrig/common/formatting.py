"""Numbers as people write them: the one formatter of terminal, reports, figures and messages.

number -> [this file] -> text without exponents of computers, negative zeros or round-off
"""

import math
from dataclasses import dataclass
from html import escape

_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_THIN = "\u202f"
"""Between groups of three digits; it does not break."""


def number(value: object, digits: int = 4) -> str:
    """A number with so many significant digits; text as it is, a dash where there is no finite number.

    Example:
        >>> number(3141.6, 2), number(-0.0), number(1.5e-7)
        ('3142', '0', '1.5·10⁻⁷')
    """
    if value is None:
        return "–"
    if isinstance(value, bool) or not isinstance(value, int | float):
        return str(value)
    if isinstance(value, int):
        return f"{value:,}".replace(",", _THIN)
    if not math.isfinite(value):
        return "–"
    if value != 0.0 and not 1e-3 <= abs(value) < 1e6:
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
        power = f"10{str(int(exponent)).translate(_SUPERSCRIPT)}"
        return power if mantissa == "1" else f"{mantissa}·{power}"
    return _plain(value, digits)


def _plain(value: float, digits: int) -> str:
    """Without a power of ten; whole numbers keep all their digits."""
    size = math.floor(math.log10(abs(value))) if value else 0
    text = f"{value:z,.{max(0, digits - 1 - size)}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return text.replace(",", _THIN if abs(value) >= 9999.5 else "")


def percent(value: float | None, digits: int = 2, *, signed: bool = False) -> str:
    """A ratio as a percentage, a dash where there is none.

    Example:
        >>> percent(0.0123, signed=True), percent(-0.0), percent(None)
        ('+1.2 %', '0 %', '–')
    """
    if value is None or not math.isfinite(value):
        return "–"
    text = number(100.0 * value, digits)
    return f"{'+' if signed and value > 0.0 else ''}{text} %"


@dataclass(frozen=True)
class Summary:
    """What something is in a few lines: a headline, rows of what and the words; it prints them."""

    headline: str
    rows: tuple[tuple[str, str], ...]

    def __repr__(self) -> str:
        width = max((len(what) for what, _ in self.rows), default=0)
        return "\n".join([self.headline, *(f"  {what:{width}}  {words}" for what, words in self.rows)])

    def _repr_html_(self) -> str:
        left = "style='text-align:left'"
        cells = (f"<tr><th {left}>{escape(a)}</th><td {left}>{escape(b)}</td></tr>" for a, b in self.rows)
        return f"<p>{escape(self.headline)}</p><table>{''.join(cells)}</table>"
