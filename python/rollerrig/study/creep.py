"""Creep laws against the exact theory on one ellipse.

a/b, names of laws -> [CreepStudy] -> forces and errors of each law; what a call costs
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import xarray as xr

from rollerrig.assembly.laws import creep_law
from rollerrig.contact_analysis.creep_laws import COMPONENTS, REFERENCE, compare_laws, error_table
from rollerrig.plot.contact import creep_figure
from rollerrig.study.frame import Study, dataset_rows
from rollerrig.study.jobs import Done, Round, job
from rollerrig.study.options import Option, command
from rollerrig.study.quantities import Numbers
from rollerrig.study.report import Picture, Section, Text


@dataclass(frozen=True)
class CreepStudy(Study[xr.Dataset]):
    """Laws by name, each once, beside the exact theory; attributes as the arguments of `rollerrig.creep`."""

    a_over_b: float
    laws: tuple[str, ...]
    poisson_ratio: float
    demands: tuple[float, ...]
    parameters: Mapping[str, Mapping[str, float]]

    command = "creep"
    heading = "Creep laws on an ellipse a/b = {a_over_b:g}"
    writes = ("creep.csv",)
    formats = ("svg", "png")
    resumable = False

    def __post_init__(self) -> None:
        """Refuse with a ValueError a law that is asked for twice, and one that no ellipse determines."""
        repeated = sorted({name for name in self.laws if self.laws.count(name) > 1})
        if repeated:
            raise ValueError(f"{', '.join(repeated)}: asked for more than once")
        if "coefficients" in self.laws:
            raise ValueError(
                "coefficients: they hold for the patch of a case; allowed: laws that follow from the ellipse"
            )

    def rounds(self, done: Done) -> Iterator[Round]:
        yield {"creep": job(compare, self)}

    def numbers(self, results: xr.Dataset) -> dict[str, Any]:
        laws: dict[str, Any] = {}
        names = [quantity.name for quantity in self.quantities.below("laws.*.*")]
        for law, kind, *errors in error_table(results):
            rounded = [round(value, 3) for value in errors]
            laws.setdefault(law, {})[kind.replace(" ", "_")] = dict(zip(names, rounded, strict=True))
        grid_error = round(100 * float(results["grid_error"].max()), 3)
        return {"a_over_b": self.a_over_b, "poisson_ratio": self.poisson_ratio, "laws": laws, "grid_error": grid_error}

    def summary(self, results: xr.Dataset, numbers: Numbers) -> list[str]:
        return [
            f"{law}: force at most {entry['no_spin']['force_worst']:.1f} % of μN off without spin, "
            f"{entry['spin']['force_worst']:.1f} % with spin."
            for law, entry in numbers["laws"].items()
        ]

    def timings(self, results: xr.Dataset) -> Mapping[str, Mapping[str, float]]:
        laws = [str(law) for law in results["law"].to_numpy() if law != REFERENCE]
        return {"processor time of a call [ns]": {law: 1e9 * float(results["seconds"].sel(law=law)) for law in laws}}

    def files(self, results: xr.Dataset, numbers: Numbers) -> Mapping[str, Any]:
        return {"creep.csv": force_rows(results)}

    def sections(self, results: xr.Dataset, numbers: Numbers) -> list[Section]:
        caption = (
            "Forces in units of the friction limit μN and spin moment in μNc, c = √(ab), over the size of the creepage. Points: "
            "exact theory; its bars are the difference to a coarser grid."
        )
        exact = (
            "Exact theory: Kalker's variational theory for half-spaces, solved here with boundary elements. Solutions on a "
            f"coarser grid differ by at most {numbers['grid_error']:g} % of μN. Poisson's ratio {self.poisson_ratio:g}. Rolling "
            "forward, signs of the force on the wheel. Equations and sources: documentation, theory/creep_laws."
        )
        entries = {f"{law}, {kind}": one for law, entry in numbers["laws"].items() for kind, one in entry.items()}
        note = "Against the exact theory. What a call costs on this machine is in timing.json."
        return [
            Section("Forces", [Picture("creep", creep_figure(results), caption)]),
            Section("Errors", [self.quantities.table(entries, "laws.*.*", note, "law, creepage"), Text(exact)]),
        ]


def compare(study: CreepStudy) -> xr.Dataset:
    """The laws of a study beside the exact theory; see `compare_laws`.

    Raises:
        ValueError: an unknown law, one that lacks a parameter, a number outside its range.
    """
    laws = {name: creep_law(name, **study.parameters.get(name, {})) for name in study.laws}
    return compare_laws(study.a_over_b, laws, poisson_ratio=study.poisson_ratio, demands=study.demands)


def force_rows(comparison: xr.Dataset) -> list[list[object]]:
    """Every force and moment, header first."""
    of_reference = comparison["adhesion"].where(comparison["law"] == REFERENCE)
    columns = {"law": "law", "direction": "direction", "demand": "demand", "xi": "xi", "eta": "eta", "chi": "chi"}
    columns |= dict(zip(("force_x_over_mu_n", "force_y_over_mu_n", "spin_moment_over_mu_n_c"), COMPONENTS, strict=True))
    creepage = {name: comparison["creepage"][..., k] + 0.0 for k, name in enumerate(("xi", "eta", "chi"))}
    forces = {name: comparison[name] + 0.0 for name in COMPONENTS}
    data = comparison.assign({**creepage, **forces, "adhesion": of_reference})
    return dataset_rows(data, columns | {"adhesion": "adhesion"}, "law", "direction", "demand")


@command
def creep(
    a_over_b: float = 1.0,
    laws: Annotated[Sequence[str], Option("law")] = ("kalker_saturated", "fastsim", "modified_fastsim", "table"),
    *,
    poisson_ratio: float = 0.28,
    demands: Sequence[float] = (0.05, 0.1, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0),
    k_A: float | None = None,
    k_S: float | None = None,
    parameters: Mapping[str, Mapping[str, float]] | None = None,
) -> xr.Dataset:
    """Forces and spin moment of creep laws beside the exact theory, with their errors and cost.

    Args:
        a_over_b: semi-axis along the rolling direction over the one across it.
        laws: creep laws by the names that `contact.creep` knows, each once.
        poisson_ratio: Poisson's ratio.
        demands: sizes of the creepage; 1 demands the friction limit [-].
        k_A: polach's k_A; dry 1.0, wet 0.3.
        k_S: polach's k_S; dry 0.4, wet 0.1.
        parameters: law -> its parameters.

    Returns:
        Dataset over (law, direction, demand), see `compare_laws`.

    Raises:
        ValueError: a number outside its range, or no law.
        RuntimeError: the exact solver found no solution.

    Example:
        >>> import rollerrig as rr
        >>> rr.creep(laws=["fastsim"], demands=(0.5, 2.0)).sizes["demand"]
        2
    """
    polach = {name: value for name, value in (("k_A", k_A), ("k_S", k_S)) if value is not None}
    if len(polach) == 1:
        raise ValueError("k_A and k_S belong together")
    if polach and "polach" not in laws:
        raise ValueError("k_A and k_S are for the law polach")
    chosen = {**(parameters or {}), **({"polach": polach} if polach else {})}
    return CreepStudy(a_over_b, tuple(laws), poisson_ratio, tuple(demands), chosen).outcome().results
