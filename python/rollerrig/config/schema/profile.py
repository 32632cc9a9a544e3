"""Which curve a wheel or a rail has; `rollerrig.profiles` turns the specification into a table of coefficients."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Discriminator, RootModel, StrictBool

from rollerrig.config.schema.base import Table, needed, optional
from rollerrig.config.schema.units import Quantity

KnotSpacing = Annotated[float, Quantity("m", 2e-6, 1e-3)]
HalfWidth = Annotated[float, Quantity("m", 1e-4, 0.5)]
Inclination = Annotated[float, Quantity("1", 0.0, 0.2)]
_STEP = "distance between the knots of the spline"


_CUT_OFF = Quantity("m", 1e-5, 0.05)


def _smoothing(value: Any) -> Any:
    """'auto' or a wavelength: one message for both."""
    if value == "auto":
        return value
    try:
        return _CUT_OFF.parse(value)
    except ValueError as error:
        raise ValueError(str(error).replace("allowed: ", "allowed: 'auto', or ", 1)) from None


Smoothing = Annotated[Literal["auto"] | Annotated[float, _CUT_OFF], BeforeValidator(_smoothing)]


class ProfileSpec(Table):
    """What every profile may say about itself."""

    name: str = optional("", "name of the profile in tables and plots")
    description: str = optional("", "description in one line")
    source: str = optional("", "origin of the definition")
    length_scale: Annotated[float, Quantity("1", 1e-3, 10.0)] = optional(
        1.0, "factor on all lengths of the finished curve: 0.2 is the profile of a 1:5 model"
    )

    def arguments(self) -> dict[str, Any]:
        """The part that defines the curve: `kind` and its parameters, without texts and unset keys."""
        return self.model_dump(exclude_none=True, exclude={"name", "description", "source"})


class S1002(ProfileSpec):
    """The wheel profile S1002 of ORE / EN 13715."""

    kind: Literal["s1002"] = needed("the wheel profile S1002, generated from its published polynomials")
    step: KnotSpacing = optional(0.05e-3, _STEP)


class Cone(ProfileSpec):
    """A wheel whose radius falls off linearly: the conical wheel of theory, without a flange."""

    kind: Literal["cone"] = needed("a conical wheel without a flange")
    conicity: Annotated[float, Quantity("1", -1.0, 1.0)] = needed("radius lost per distance outward, also as '1:20'")
    half_width: HalfWidth = optional(60e-3, "half of the width of the tread")


class Uic60(ProfileSpec):
    """The rail head UIC60 / 60E1: arcs R300, R80 and R13 and a side 1:20."""

    kind: Literal["uic60"] = needed("the rail head UIC60 / 60E1, generated from its arcs")
    variant: Literal["en_13674", "benchmark"] = optional("en_13674", "arcs by EN 13674-1, or the Manchester benchmark")
    inclination: Inclination = optional(0.025, "lean towards the track centre, a number or a ratio like '1:40'")
    step: KnotSpacing = optional(0.05e-3, _STEP)


class Cylinder(ProfileSpec):
    """A constant profile, for comparison with theory."""

    kind: Literal["cylinder"] = needed("a flat rail head, a cylindrical roller or a cylindrical wheel")
    half_width: HalfWidth = optional(36e-3, "half of its width")


class Arc(ProfileSpec):
    """A circular profile, for comparison with theory."""

    kind: Literal["arc"] = needed("a convex circular rail head or wheel")
    radius: Annotated[float, Quantity("m", 1e-3, 1e6, bare=10.0)] = needed("radius of the arc")
    half_width: HalfWidth = optional(36e-3, "half of its width")


class ProfileFile(ProfileSpec):
    """A measured profile."""

    kind: Literal["file"] = needed("points from a text file")
    path: str = needed("the file, relative to the file that names it", min_length=1)
    format: Literal["auto", "two_column", "simpack"] = optional(
        "auto", "two columns of numbers, or Simpack's .prw / .prr text; auto decides by the content"
    )
    units: Literal["auto", "mm", "m"] = optional("auto", "unit of a two-column file; auto decides by the size")
    inner_side: Literal["auto", "negative", "positive"] = optional(
        "auto", "sign of the file's abscissa on the flange or gauge side; auto looks for the flange"
    )
    z_positive: Literal["auto", "up", "down"] = optional(
        "auto", "whether the file's ordinate grows up or down as mounted; auto looks at the flanks"
    )
    tape_circle: Annotated[float, Quantity("m", -1.0, 1.0)] = optional(
        0.0, "abscissa of the tape circle in the file's own axes; wheels only"
    )
    inclination: Annotated[float, Quantity("1", -0.2, 0.2)] = optional(
        0.0, "further lean of a rail towards the track centre; 0 where the file is already inclined"
    )
    smoothing: Smoothing = optional(
        "auto", "cut-off wavelength of the smoothing; auto: the shortest that leaves a usable curvature"
    )
    require_flange: StrictBool = optional(True, "refuse a wheel without a flange")
    step: KnotSpacing = optional(0.05e-3, _STEP)


AnyProfile = Annotated[S1002 | Cone | Uic60 | Cylinder | Arc | ProfileFile, Discriminator("kind")]


class ProfileRoot(RootModel[AnyProfile]):
    """A profile of any kind, as a file of its own."""
