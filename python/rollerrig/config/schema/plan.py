"""A plan of a sweep: a case, what is varied in it, how the values are chosen, what is computed and kept of each case."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Discriminator, Field

from rollerrig.config.schema.base import Mistakes, Name, Named, OrShort, Table, by_kind, needed, optional
from rollerrig.config.schema.programme import AnyStop, UniformStop
from rollerrig.config.schema.units import Angle, Position, Quantity, Time

Plain = float | str
SearchedSpeed = Annotated[float, Quantity("m/s", 0.1, 200.0, bare=10.0)]
Count = Annotated[int, Field(ge=2)]


def _value(value: Any) -> Any:
    """A number, or a text with a unit: which unit is known where the key is."""
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise ValueError("allowed: a number or a text with a unit")
    return value


Value = Annotated[Plain, BeforeValidator(_value)]


class Normal(Table):
    """A normal distribution."""

    kind: Literal["normal"] = needed("a normal distribution")
    mean: Value = needed("mean, in the unit of the key")
    deviation: Value = needed("standard deviation, positive, in the unit of the key")


class Lognormal(Table):
    """A quantity whose logarithm is normally distributed."""

    kind: Literal["lognormal"] = needed("the logarithm is normally distributed")
    median: Value = needed("median, positive, in the unit of the key")
    deviation: Annotated[float, Quantity("1", 1e-6, 10.0)] = needed("standard deviation of the logarithm: 0.1 is 10 %")


class Triangular(Table):
    """A triangular distribution between `least` and `most`."""

    kind: Literal["triangular"] = needed("rises from `least` to the mode and falls to `most`")
    mode: Value = needed("the most frequent value, in the unit of the key")


AnyDistribution = Annotated[Normal | Lognormal | Triangular, Discriminator("kind")]


class OfKey(Table):
    """What is said of a key of the case."""

    key: str = needed(
        "dotted key of the case, as in `--set`: `support.roller_radius`; with `*` all that match get the same value",
        min_length=1,
    )
    name: Name | None = optional(None, "name in results and figures; absent: the end of the key")

    @property
    def label(self) -> str:
        """Its name in results."""
        return self.name or next(part for part in reversed(self.key.split(".")) if not part.isdecimal()).strip("*[]_")


class Variation(OfKey):
    """One thing that is varied: by a list, a range, or a distribution."""

    values: tuple[Any, ...] | None = optional(None, "all values, also with units or as words", min_length=1)
    least: Value | None = optional(None, "lower end of a range; it cuts a distribution off")
    most: Value | None = optional(None, "upper end")
    count: Count | None = optional(None, "values of a range in a grid, both ends included")
    scale: Literal["linear", "logarithmic"] = optional(
        "linear", "division of a range, or where in it samples are equally likely"
    )
    distribution: AnyDistribution | None = optional(None, "distribution of the samples; absent: uniform in the range")

    def _mistakes(self) -> Mistakes:
        if self.values is not None:
            for key in ("least", "most", "count", "distribution"):
                if getattr(self, key) is not None:
                    yield key, "allowed: one of `values`, and a range or distribution"
        elif self.distribution is None or self.distribution.kind == "triangular":
            for key in ("least", "most"):
                if getattr(self, key) is None:
                    yield key, "needed: `values`, or both `least` and `most`, or a distribution"


class Design(Table):
    """How the cases are chosen among all values."""

    kind: Literal["grid", "list", "random", "latin_hypercube", "sobol", "saltelli"] = optional(
        "grid",
        "grid: all combinations; list: the n-th value of each together; random, latin_hypercube, sobol: samples; "
        "saltelli: the samples that Sobol indices need, samples x (variations + 2) cases",
    )
    samples: Annotated[int, Field(ge=2, le=10**12)] | None = optional(None, "number; a power of 2 for sobol, saltelli")
    seed: Annotated[int, Field(ge=0, lt=2**32)] = optional(1, "seed of the samples")

    def _mistakes(self) -> Mistakes:
        sampled = self.kind not in ("grid", "list")
        if sampled and self.samples is None:
            yield "samples", f"needed by the design {self.kind}: how many samples"
        if not sampled and self.samples is not None:
            yield "samples", f"allowed: nothing here; a {self.kind} has the values of its variations"
        if self.kind in ("sobol", "saltelli") and self.samples is not None and self.samples & (self.samples - 1):
            below = 2 ** (self.samples.bit_length() - 1)
            yield "samples", f"allowed with {self.kind}: a power of 2, such as {below} or {2 * below}"


AnyDesign = Annotated[
    Design, BeforeValidator(by_kind().completed), OrShort({"enum": ["grid", "list"]}, words="grid, list")
]


class Measure(Table):
    """What every measure has."""

    keep: tuple[str, ...] = optional((), "names of numbers that are kept; none: all", max_length=100)


class RunMeasure(Measure):
    """Simulate the case; numbers of wheel-rail forces and motion."""

    kind: Literal["run"] = needed("simulate the case: wheel-rail forces, motion, energy")
    begin: Annotated[float, Quantity("s", 0.0, 1e5)] = optional(0.0, "time from which the run is assessed")


class StabilityMeasure(Measure):
    """Modes at the speed of the case."""

    kind: Literal["stability"] = needed("modes at the speed of the case")


class CriticalSpeedMeasure(Measure):
    """Linear critical speed."""

    kind: Literal["critical_speed"] = needed("linear critical speed")
    slowest: SearchedSpeed = optional(60 / 3.6, "lowest speed at which it is looked for")
    fastest: SearchedSpeed = optional(400 / 3.6, "highest speed at which it is looked for")

    def _mistakes(self) -> Mistakes:
        if not self.fastest > self.slowest:
            yield "fastest", f"allowed: more than `slowest`, {3.6 * self.slowest:g} km/h"


class ContactMeasure(Measure):
    """Contact of the leading wheelset under its static load."""

    kind: Literal["contact"] = needed("contact patches of the leading wheelset under its static axle load")
    lateral: Position = optional(0.0, "lateral position of the wheelset")
    yaw: Angle = optional(0.0, "yaw angle of the wheelset")


class AdhesionMeasure(Measure):
    """The test on degraded track and on the rig that reproduces it."""

    kind: Literal["adhesion"] = needed("the test on degraded track and on the rig that reproduces it")
    longest: Time | None = optional(None, "end of both runs; absent: that of the case")


class WspMeasure(Measure):
    """A stop of a test programme for wheel slide protection, and the same on a dry rail, both on track; nothing is drawn."""

    kind: Literal["wsp"] = needed("a stop as of a test programme for slide protection, on track, and its dry reference")
    stop: AnyStop = optional(
        UniformStop.model_validate({"name": "low_80", "kind": "uniform", "speed": "80 km/h", "rail": "low"}),
        "the stop, as in a programme",
    )


class CreepMeasure(Measure):
    """Creep forces of the case's law on the contact patch of its leading left wheel."""

    kind: Literal["creep"] = needed("creep forces on the largest patch of the leading wheelset, centred")
    longitudinal: Annotated[float, Quantity("1", -10.0, 10.0)] = optional(-1e-3, "creepage")
    lateral: Annotated[float, Quantity("1", -10.0, 10.0)] = optional(0.0, "creepage")
    spin: Annotated[float, Quantity("1/m", -100.0, 100.0)] = optional(0.0, "spin creepage")


AnyMeasure = Annotated[
    RunMeasure | StabilityMeasure | CriticalSpeedMeasure | ContactMeasure | AdhesionMeasure | WspMeasure | CreepMeasure,
    by_kind("run"),
]


class Plan(Named):
    """A case, what is varied in it, and what is computed and kept."""

    case: str = needed("the case: a name of the catalogue, or a file", min_length=1)
    changes: dict[str, Any] = optional({}, "dotted key of the case -> value that all cases of the sweep have")
    design: AnyDesign = optional(Design(), "choice of the cases")
    vary: tuple[Variation, ...] = needed("keys that are varied", min_length=1, max_length=100)
    measure: tuple[AnyMeasure, ...] = needed("quantities that are computed of each case", max_length=20)
