"""A plan of a sweep: a case, what is varied in it, how the values are chosen, what is computed and kept of each case."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Discriminator, Field

from rollerrig.config.schema.base import Mistakes, Name, Named, OrShort, Table, by_kind, optional
from rollerrig.config.schema.programme import AnyStop, UniformStop
from rollerrig.config.schema.units import Angle, Position, Quantity, Time

Plain = float | str
Count = Annotated[int, Field(ge=2)]


def _value(value: Any) -> Any:
    """A number, or a text with a unit: which unit is known where the key is."""
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise ValueError("allowed: a number or a text with a unit")
    return value


Value = Annotated[Plain, BeforeValidator(_value)]


class Normal(Table):
    """A normal distribution."""

    kind: Literal["normal"] = Field(description="a normal distribution")
    mean: Value = Field(description="its mean, in the unit of the key")
    deviation: Value = Field(description="its standard deviation, positive, in the unit of the key")


class Lognormal(Table):
    """A quantity whose logarithm is normally distributed."""

    kind: Literal["lognormal"] = Field(description="the logarithm is normally distributed")
    median: Value = Field(description="its median, positive, in the unit of the key")
    deviation: Annotated[float, Quantity("1", 1e-6, 10.0)] = Field(
        description="standard deviation of the natural logarithm: 0.1 is about 10 %"
    )


class Triangular(Table):
    """A triangular distribution between `least` and `most`."""

    kind: Literal["triangular"] = Field(description="rises from `least` to the mode and falls to `most`")
    mode: Value = Field(description="the most frequent value, in the unit of the key")


AnyDistribution = Annotated[Normal | Lognormal | Triangular, Discriminator("kind")]


class Variation(Table):
    """One thing that is varied: by a list, a range, or a distribution."""

    key: str = Field(
        min_length=1,
        description="dotted key of the case, as in `--set`: `support.roller_radius`; with `*` all that match get the same value",
    )
    name: Name | None = optional(None, "in results and figures; absent: the end of the key")
    values: tuple[Any, ...] | None = Field(
        default=None, min_length=1, description="all values, with or without units; or words, where the key takes them"
    )
    least: Value | None = optional(None, "lower end of a range; it cuts a distribution off")
    most: Value | None = optional(None, "upper end")
    count: Count | None = optional(None, "values of a range in a grid, both ends included")
    scale: Literal["linear", "logarithmic"] = optional(
        "linear", "how a range is divided, or where in it samples are equally likely"
    )
    distribution: AnyDistribution | None = optional(
        None, "distribution of the samples; absent: all values of the range are equally likely"
    )

    def _mistakes(self) -> Mistakes:
        if self.values is not None:
            for key in ("least", "most", "count", "distribution"):
                if getattr(self, key) is not None:
                    yield key, "allowed: one of `values`, and a range or distribution"
        elif self.distribution is None or self.distribution.kind == "triangular":
            for key in ("least", "most"):
                if getattr(self, key) is None:
                    yield key, "needed: `values`, or both `least` and `most`, or a distribution"

    @property
    def label(self) -> str:
        """Its name in results."""
        return self.name or next(part for part in reversed(self.key.split(".")) if not part.isdecimal()).strip("*[]_")


class Design(Table):
    """How the cases are chosen among all values."""

    kind: Literal["grid", "list", "random", "latin_hypercube", "sobol", "saltelli"] = optional(
        "grid",
        "grid: all combinations; list: the n-th value of each together; random, latin_hypercube, sobol: samples; "
        "saltelli: the samples that Sobol indices need, samples x (variations + 2) cases",
    )
    samples: Annotated[int, Field(ge=2, le=10**12)] | None = optional(
        None, "how many samples; a power of 2 for sobol and saltelli"
    )
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

    keep: tuple[str, ...] = Field(
        default=(), max_length=100, description="names of the numbers that are kept; none: all"
    )


class RunMeasure(Measure):
    """Simulate the case; numbers of wheel-rail forces and motion."""

    kind: Literal["run"] = Field(description="simulate the case: wheel-rail forces, motion, energy")
    begin: Annotated[float, Quantity("s", 0.0, 1e5)] = optional(
        0.0, "time from which the run is assessed: what comes before is not"
    )


class StabilityMeasure(Measure):
    """Modes at the speed of the case."""

    kind: Literal["stability"] = Field(description="modes at the speed of the case")


class CriticalSpeedMeasure(Measure):
    """Linear critical speed."""

    kind: Literal["critical_speed"] = Field(description="linear critical speed")
    slowest: Annotated[float, Quantity("m/s", 0.1, 200.0, bare=10.0)] = optional(
        60 / 3.6, "lowest speed at which it is looked for"
    )
    fastest: Annotated[float, Quantity("m/s", 0.1, 200.0, bare=10.0)] = optional(
        400 / 3.6, "highest speed at which it is looked for"
    )

    def _mistakes(self) -> Mistakes:
        if not self.fastest > self.slowest:
            yield "fastest", f"allowed: more than `slowest`, {3.6 * self.slowest:g} km/h"


class ContactMeasure(Measure):
    """Contact of the leading wheelset under its static load."""

    kind: Literal["contact"] = Field(description="contact patches of the leading wheelset under its static axle load")
    lateral: Position = optional(0.0, "lateral position of the wheelset")
    yaw: Angle = optional(0.0, "yaw angle of the wheelset")


class AdhesionMeasure(Measure):
    """The test on degraded track and on the rig that reproduces it."""

    kind: Literal["adhesion"] = Field(description="the test on degraded track and on the rig that reproduces it")
    longest: Time | None = optional(None, "end of both runs; absent: that of the case")


class WspMeasure(Measure):
    """A stop of a test programme for wheel slide protection, and the same on a dry rail, both on track; nothing is drawn."""

    kind: Literal["wsp"] = Field(
        description="a stop as of a test programme for slide protection, on track, and its dry reference"
    )
    stop: AnyStop = optional(
        UniformStop.model_validate({"name": "low_80", "kind": "uniform", "speed": "80 km/h", "rail": "low"}),
        "the stop, as in a programme",
    )


class CreepMeasure(Measure):
    """Creep forces of the case's law on the contact patch of its leading left wheel."""

    kind: Literal["creep"] = Field(description="creep forces on the largest patch of the leading wheelset, centred")
    longitudinal: Annotated[float, Quantity("1", -10.0, 10.0)] = optional(-1e-3, "creepage")
    lateral: Annotated[float, Quantity("1", -10.0, 10.0)] = optional(0.0, "creepage")
    spin: Annotated[float, Quantity("1/m", -100.0, 100.0)] = optional(0.0, "spin creepage")


AnyMeasure = Annotated[
    RunMeasure | StabilityMeasure | CriticalSpeedMeasure | ContactMeasure | AdhesionMeasure | WspMeasure | CreepMeasure,
    Discriminator("kind"),
    by_kind("run"),
]


class Plan(Named):
    """A case, what is varied in it, and what is computed and kept."""

    case: str = Field(min_length=1, description="the case: a name of the catalogue, or a file")
    changes: dict[str, Any] = optional({}, "dotted key of the case -> value that all cases of the sweep have")
    design: AnyDesign = optional(Design(), "how the cases are chosen")
    vary: tuple[Variation, ...] = Field(min_length=1, max_length=100, description="what is varied")
    measure: tuple[AnyMeasure, ...] = Field(max_length=20, description="what is computed of each case")
