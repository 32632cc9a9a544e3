"""Methods and steps of the shipped cases: errors and cost of each, and the cheapest that is good enough.

    python scripts/choose_steps.py [CASE ...] [--quick] [--contact NORMAL CREEP] [--write]

For each case, a run with each of the candidates below, contact as the case has it or as said. Two tight references, by two
methods that have nothing in common but the right-hand side: where a limit cycle, or a controller that decides at its samples,
lets them drift apart by 0.03 % of a signal's largest value, the comparison ends, and the table says when. A candidate is good
enough where every kind of signal is within 0.1 % up to there and the energy audit of the whole run closes within 1e-6. The
cheapest in processor time is chosen; right-hand sides per simulated millisecond stand beside, which another machine shares.

--write puts the table into docs/performance.md and the choice into the cases.
"""

from __future__ import annotations

import argparse
import re
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "benchmarks"))
from step_errors import Measured, agree_until, errors, measure, signals  # noqa: E402
from timing import write_between  # noqa: E402

from rollerrig import Case, ConfigError, load_case  # noqa: E402

GOOD = 1e-3
"""Largest error of a kind of signal."""

CLOSED = 1e-6
"""Largest relative energy residual."""

CONVERGED = 3e-4
"""Where two references differ by more, the comparison ends."""

LONGEST = {False: 6.0, True: 20.0}
"""Of a run, without and with sampled blocks [s]."""

CASES = ROOT / "python/rollerrig/catalog/cases"


@dataclass(frozen=True)
class Candidate:
    """A method with its step or tolerance."""

    method: str
    step_ms: float | None
    tolerance: float | None = None

    @property
    def text(self) -> str:
        """As the table names it."""
        step = "" if self.step_ms is None else f", {self.step_ms:g} ms"
        return f"{self.method}{step}" + ("" if self.tolerance is None else f", {self.tolerance:g}")

    def settings(self) -> dict[str, object]:
        """Keys of [time]; the absolute tolerance of a displacement is a thousandth of the relative one, in metres."""
        keys: dict[str, object] = {
            "method": self.method,
            "step": None if self.step_ms is None else f"{self.step_ms:g} ms",
        }
        if self.tolerance is not None:
            keys |= {"relative_tolerance": self.tolerance, "absolute_tolerance": 1e-3 * self.tolerance}
        return keys


PLAIN = (
    Candidate("rk4", 0.25),
    Candidate("exponential_rk4", 0.5),
    Candidate("exponential_rk4", 1.0),
    Candidate("exponential_adams", 1.0, 1e-4),
    Candidate("exponential_adams", 1.0, 1e-5),
    Candidate("exponential_adams", 1.5, 1e-4),
    Candidate("exponential_adams", 1.5, 1e-5),
    Candidate("exponential_adams", 2.0, 1e-4),
    Candidate("exponential_adams", 2.0, 1e-5),
    Candidate("rodas4", None, 1e-4),
    Candidate("rodas4", None, 1e-5),
)
SAMPLED = (
    Candidate("exponential_rk4", 0.5),
    Candidate("exponential_rk4", 1.0),
    Candidate("exponential_adams", 1.0, 1e-4),
    Candidate("exponential_adams", 1.0, 1e-5),
    Candidate("exponential_adams", 1.0, 1e-6),
    Candidate("exponential_adams", 1.0, 3e-7),
    Candidate("exponential_adams", 1.0, 1e-7),
)
REFERENCES = (Candidate("exponential_adams", 0.25, 1e-8), Candidate("exponential_rk4", 0.125))


@dataclass(frozen=True)
class Row:
    """A candidate of a case: what it gave."""

    candidate: Candidate
    measured: Measured
    errors: dict[str, float]

    @property
    def good(self) -> bool:
        """Whether it may be chosen."""
        return max(self.errors.values()) <= GOOD and self.measured.energy <= CLOSED


def shortened(name: str, quick: bool, contact: list[str] | None) -> Case:
    """A shipped case, no longer than it takes to see the errors."""
    case = load_case(name)
    longest = LONGEST[case.sampled] * (0.25 if quick else 1.0)
    output = min(case.time.output_step, 5e-3)  # that the low-pass needs
    laws = dict(zip(("contact.normal", "contact.creep"), contact or (), strict=False))
    return case.with_changes({"time.duration": min(case.time.duration, longest), "time.output_step": output, **laws})


def with_method(case: Case, candidate: Candidate) -> Case:
    """The case with the method; a sampled run's step is in units of its sampling step over 1 ms."""
    settings = candidate.settings()
    if case.sampled and candidate.step_ms is not None:
        settings["step"] = candidate.step_ms * case.time.sampling_step
    return case.with_changes({f"time.{key}": value for key, value in settings.items()})


def ships(case: Case, candidate: Candidate) -> bool:
    """Whether it is the case's own method, step and tolerance."""
    tried = with_method(case, candidate)
    return tried.integration == case.integration and tried.time.relative_tolerance == case.time.relative_tolerance


def compare(case: Case) -> tuple[float, list[Row]]:
    """Time up to which the references agree [s], and a row for each candidate that the case does not refuse."""
    tight, other = (signals(measure(with_method(case, c)).run) for c in REFERENCES)
    until = agree_until(tight, other, CONVERGED)
    rows = []
    for candidate in SAMPLED if case.sampled else PLAIN:
        try:
            found = measure(with_method(case, candidate), repeat=2)
        except ConfigError:
            continue  # an unstable step
        rows.append(Row(candidate, found, errors(signals(found.run), tight, until)))
    return until, rows


def chosen(rows: list[Row]) -> Row | None:
    """The cheapest that is good enough."""
    return max((row for row in rows if row.good), key=lambda row: row.measured.real_time, default=None)


def table(name: str, until: float, rows: list[Row]) -> str:
    """In Markdown; what the case is shipped with stands in bold."""
    case = load_case(name)
    kinds = list(rows[0].errors)
    shipped = next((row for row in rows if ships(case, row.candidate)), rows[0])
    head = f"| `{name}`, first {until:.3g} s | time over {shipped.candidate.text} | evaluations/ms | "
    head += " | ".join(kinds) + " | energy |"
    lines = [head, "|---" * (4 + len(kinds)) + "|"]
    for row in rows:
        mark = "**" if ships(case, row.candidate) else ""
        numbers = [f"{shipped.measured.real_time / row.measured.real_time:.2f}", f"{row.measured.evaluations:.2f}"]
        numbers += [f"{value:.1e}" for value in (*row.errors.values(), row.measured.energy)]
        lines.append(f"| {mark}{row.candidate.text}{mark} | " + " | ".join(numbers) + " |")
    return "\n".join(lines)


def write_case(name: str, row: Row) -> None:
    """Put the choice into the case's table [time]."""
    path = CASES / f"{name}.toml"
    head, _, rest = path.read_text().partition("\n[time]\n")
    own, separator, tail = rest.partition("\n[")
    own = "\n".join(
        line for line in own.splitlines()
        if not re.match(r"(method|step|relative_tolerance|absolute_tolerance)\b", line)
    )  # fmt: skip
    settings = row.candidate.settings()
    if load_case(name).sampled:  # the step is the sampling step
        settings.pop("step")
        settings.pop("method")
    added = "\n".join(f"{key} = {value!r}".replace("'", '"') for key, value in settings.items() if value is not None)
    path.write_text(f"{head}\n[time]\n{own}\n{added}\n{separator}{tail}")


def main() -> None:
    """Print the tables; with --write also into the page and the cases."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", help="shipped cases (default: all that run)")
    parser.add_argument("--quick", action="store_true", help="a quarter of each run")
    parser.add_argument("--contact", nargs=2, metavar=("NORMAL", "CREEP"), help="laws of contact, e.g. strips table")
    parser.add_argument("--write", action="store_true", help="into docs/performance.md and the cases")
    options = parser.parse_args()
    names = options.cases or sorted(path.stem for path in CASES.glob("*.toml"))
    tables = []
    for name in names:
        until, rows = compare(shortened(name, options.quick, options.contact))
        tables.append(table(name, until, rows))
        print(tables[-1], end="\n\n", flush=True)
        best = chosen(rows)
        if options.write and best is not None:
            write_case(name, best)
    if options.write:
        write_between("steps", "\n\n".join(tables))


if __name__ == "__main__":
    main()
