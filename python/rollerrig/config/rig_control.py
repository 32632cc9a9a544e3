"""The rig's controller: the train it imitates, how it estimates, how it corrects, and when it gives up."""

from typing import Annotated, Literal

from pydantic import Field

from rollerrig.config.base import Table
from rollerrig.config.machines import Controller, Frequency, Motor
from rollerrig.config.units import Mass, PositiveLength, PositiveTime, Quantity

Inertia = Annotated[float, Quantity("kg m^2", gt=0)]


class Train(Table):
    """The train of which the axles under test brake or pull their part."""

    mass: Mass | None = Field(default=None, description="per bogie under test; absent: what its axles carry")
    resistance_constant: Annotated[float, Quantity("N", ge=0)] = Field(
        default=0.0, description="A in R = A + B v + C v^2"
    )
    resistance_linear: Annotated[float, Quantity("N s/m", ge=0)] = Field(default=0.0, description="B")
    resistance_quadratic: Annotated[float, Quantity("N s^2/m^2", ge=0)] = Field(default=0.0, description="C")
    gradient: Annotated[float, Quantity("1", ge=-0.1, le=0.1)] = Field(default=0.0, description="positive uphill")


class Estimator(Table):
    """Contact force and axle torque from the rollers' side."""

    kind: Literal["observer", "filtered_derivative"] = Field(
        default="observer", description="of disturbance (Luenberger), or a filtered derivative of the roller's speed"
    )
    bandwidth: Frequency = Field(default=20.0, description="of the estimate")
    damping_ratio: Annotated[float, Quantity("1", gt=0, le=2)] = Field(
        default=0.8, description="of the observer's poles"
    )


class Feedback(Table):
    """What corrects the wheels' speeds; gains that are absent follow from bandwidth, damping and inertias."""

    kind: Literal["proportional_integral", "sliding_mode", "none"] = Field(
        default="proportional_integral", description="on virtual minus measured axle speed"
    )
    bandwidth: Frequency = Field(
        default=0.7, description="of the loop: far below the estimator, whose errors it is to remove"
    )
    damping_ratio: Annotated[float, Quantity("1", gt=0, le=5)] = Field(default=0.7, description="of the loop")
    proportional: Annotated[float, Quantity("N m s/rad", ge=0)] | None = Field(default=None, description="gain")
    integral: Annotated[float, Quantity("N m/rad", ge=0)] | None = Field(default=None, description="gain")
    switching: Annotated[float, Quantity("N m", ge=0)] = Field(default=1000.0, description="torque of the sliding mode")
    boundary_layer: Annotated[float, Quantity("rad/s", gt=0)] = Field(
        default=0.5, description="of the sliding mode: it acts in proportion within"
    )
    largest: Annotated[float, Quantity("N m", gt=0)] = Field(
        default=2e4, description="torque asked of a roller's drive"
    )


class Protection(Table):
    """Ends a test before rollers and wheels are damaged."""

    slip: Annotated[float, Quantity("m/s", gt=0)] = Field(
        default=1.0, description="real sliding of wheel on roller ..."
    )
    time: PositiveTime = Field(default=0.2, description="... for longer than this")


class Believed(Table):
    """Numbers in the controller that may differ from the rig's; absent: right."""

    roller_inertia: Inertia | None = Field(default=None, description="of a roller axle about its axis")
    wheelset_inertia: Inertia | None = Field(default=None, description="about its axis")
    roller_radius: PositiveLength | None = Field(default=None, description="of the rollers")
    wheel_radius: PositiveLength | None = Field(default=None, description="of the wheels")


class RigControl(Controller):
    """Controller of the roller drives: the wheels turn as those of a train on the rail of [adhesion]."""

    sample_time: PositiveTime = Field(default=1e-3, description="a multiple of bench.step")
    delay: Annotated[float, Quantity("s", ge=0)] = Field(
        default=0.0, description="of the command, a multiple of bench.step"
    )
    train: Train = Field(default=Train(), description="the virtual train")
    estimator: Estimator = Field(default=Estimator(), description="of the contact force")
    feedback: Feedback = Field(default=Feedback(), description="on the axles' speeds")
    motor: Motor = Field(default=Motor(), description="drive of each roller axle")
    protection: Protection = Field(default=Protection(), description="of the rollers")
    believed: Believed = Field(default=Believed(), description="what the controller believes in")
