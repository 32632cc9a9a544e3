"""What the rails deviate from their design position: a published spectrum, or a measured file."""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Discriminator, Field, StrictInt, model_validator

from rollerrig.config.schema.base import Table, refused
from rollerrig.config.schema.units import Quantity
from rollerrig.irregularity import RailIrregularity, generate, measured_irregularity, read_measured_track


class Deviation(Table):
    """What every irregularity may say about itself."""

    length_scale: Annotated[float, Quantity("1", 1e-3, 10.0)] = Field(
        default=1.0,
        description="factor on all lengths, along the track and of the displacements: 0.2 are the rails of a 1:5 model; every "
        "other key is that of the full-scale track",
    )

    fade_in: Annotated[float, Quantity("m", 0.0, 1e4)] = Field(
        default=20.0,
        description="length from where the foremost wheelset starts, over which it grows from nothing to its full size",
    )
    scale: Annotated[float, Quantity("1", 0.0, 10.0)] = Field(
        default=1.0, description="factor on all displacements; 1.414 reads a published spectrum as a two-sided one"
    )


class SpectrumIrregularity(Deviation):
    """Rails with a published spectrum, random phases: alignment, vertical, cross level and gauge."""

    kind: Literal["ore_b176"] = Field(description="the spectra of ORE B 176, generated; repeats after `period`")
    level: Literal["low", "high"] = Field(description="level of the spectra")
    seed: Annotated[StrictInt, Field(ge=0, le=2**32 - 1)] = Field(
        default=1, description="another number, other rails of the same spectrum"
    )
    shortest_wavelength: Annotated[float, Quantity("m", 0.5, 1e3)] = Field(default=3.0, description="shortest wave")
    longest_wavelength: Annotated[float, Quantity("m", 0.5, 1e4)] = Field(default=100.0, description="longest wave")
    period: Annotated[float, Quantity("m", 1.0, 1e5)] = Field(
        default=2000.0,
        description="distance after which the rails repeat; not tied to the run, so that a seed always means the same rails",
    )

    @model_validator(mode="after")
    def _ordered(self) -> "SpectrumIrregularity":
        for key, value, name, least in (
            ("longest_wavelength", self.longest_wavelength, "shortest_wavelength", self.shortest_wavelength),
            ("period", self.period, "longest_wavelength", self.longest_wavelength),
        ):
            if value < least:
                raise refused(key, f"allowed: at least {name}, {least:g} m")
        return self


class MeasuredIrregularity(Deviation):
    """Rails from a measured file."""

    kind: Literal["file"] = Field(description="a CSV file of measured rails, columns with units")
    path: str = Field(min_length=1, description="the file, relative to the file that names it")
    start: Annotated[float, Quantity("m", -1e6, 1e6)] | None = Field(
        default=None,
        description="distance in the file at which the middle of the vehicle (or of its cut) starts; absent: the "
        "foremost wheelset starts at the first row",
    )


AnyIrregularity = Annotated[SpectrumIrregularity | MeasuredIrregularity, Discriminator("kind")]


def rails_of_run(
    irregularity: SpectrumIrregularity | MeasuredIrregularity, foremost: float, distance: float
) -> RailIrregularity:
    """The rails of a run.

    Args:
        irregularity: what the configuration says.
        foremost: how far ahead of the middle of the vehicle its foremost wheelset stands [m].
        distance: length of the run [m].

    Raises:
        IrregularityError: a measured file cannot be used, or is shorter than the run.
    """
    scale = irregularity.length_scale
    rails = _full_scale_rails(irregularity, foremost / scale, distance / scale)
    return rails if scale == 1.0 else rails.scaled(scale)


def _full_scale_rails(
    irregularity: SpectrumIrregularity | MeasuredIrregularity, foremost: float, distance: float
) -> RailIrregularity:
    if isinstance(irregularity, SpectrumIrregularity):
        return generate(
            irregularity.level,
            irregularity.seed,
            shortest=irregularity.shortest_wavelength,
            longest=irregularity.longest_wavelength,
            period=irregularity.period,
            fade_in=irregularity.fade_in,
            scale=irregularity.scale,
        )
    track = read_measured_track(Path(irregularity.path))
    start = float(track.distance[0]) - foremost if irregularity.start is None else irregularity.start
    return measured_irregularity(
        track,
        start=start,
        needed=(foremost, foremost + distance),
        fade_in=irregularity.fade_in,
        scale=irregularity.scale,
    )
