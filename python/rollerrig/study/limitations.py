"""What the model of a case leaves out: sentences that follow from the case.

Case -> [limitations] -> sentences for the report
"""

from collections.abc import Iterator

from rollerrig.config import Case, Rig
from rollerrig.config.schema.contact import KalkerLinear, KalkerSaturated


def limitations(case: Case) -> list[str]:
    """What the model of this case leaves out, a sentence each."""
    return [*_structure(case), *_geometry(case), *_contact(case), *_adhesion(case), *_actuators(case)]


def _structure(case: Case) -> Iterator[str]:
    yield "Car bodies, frames and wheelsets are rigid."
    fixed = case.vehicle.part.fixed
    if fixed:
        yield f"Fixed, as on a test rig: {', '.join(name.replace('_', ' ') for name in fixed)}."
    support = case.support.data
    if isinstance(support, Rig):
        yield (
            "The rollers are rigid and their axles only spin in rigid bearings."
            if support.mounting is None
            else "The rollers are rigid; their axles stand on linear springs and dampers."
        )
    else:
        yield (
            "The rails are rigid and do not move."
            if support.foundation is None
            else "The rails are rigid; the piece below each wheel stands on linear springs and dampers, and pieces do not "
            "interact."
        )


def _geometry(case: Case) -> Iterator[str]:
    support = case.support.data
    if support.irregularity is None:
        smooth = "rollers are perfectly round" if isinstance(support, Rig) else "track is free of irregularities"
        yield f"The {smooth}, and profiles do not wear."
        return
    if support.irregularity.kind == "file":
        yield "Irregularities are those of the measured file, no shorter than its sampling resolves; profiles do not wear."
    else:
        shortest = support.irregularity.shortest_wavelength
        yield (
            f"Irregularities are one realisation of a stationary spectrum without wavelengths below {shortest:g} m; profiles do "
            "not wear."
        )
    if isinstance(support, Rig):
        yield "The actuators follow the irregularity exactly; the rollers themselves are perfectly round."


def _contact(case: Case) -> Iterator[str]:
    contact = case.contact
    yield contact.normal.limitation
    yield f"{contact.creep.limitation} Rolling contact is quasi-steady: each patch has its steady force at once."
    if isinstance(contact.creep, KalkerLinear | KalkerSaturated) and not getattr(
        contact.creep, "saturate_spin_moment", False
    ):
        yield "The spin moment is not limited by friction."
    off = [name for name, on in contact.roller_effects.model_dump().items() if not on]
    if off and isinstance(case.support.data, Rig):
        yield f"Switched off, unlike on a real rig: the rollers' effect of {', '.join(off)}."


def _adhesion(case: Case) -> Iterator[str]:
    if case.adhesion is None:
        yield case.contact.friction.limitation
        return
    recovery = (
        "recovers by the dissipated energy alone"
        if case.adhesion.recovery_constant > 0.0
        else "is not changed by sliding"
    )
    yield (
        "The adhesion of the rail depends on place or time and on the slip velocity as given, without temperature, and "
        f"{recovery}."
    )


def _actuators(case: Case) -> Iterator[str]:
    if case.motion.drive == "speed_controlled" and case.rig_control is None:
        what = "rollers' speed is" if isinstance(case.support.data, Rig) else "running speed is"
        yield f"The {what} prescribed: no drive reacts to the contact forces."
    if case.contact.pure_rolling:
        yield "Wheels roll on the rollers without longitudinal sliding (pure-rolling assumption)."
    if case.rig_control is not None:
        transfer = "no load transfer" if case.rig_control.load_transfer == "none" else "quasi-static load transfer"
        yield (
            "The virtual train runs straight ahead on centred wheels with one elliptical patch each: no lateral motion, no "
            f"spin, {transfer}."
        )
        if case.rig_control.estimator.kind == "exact":
            yield "Contact force and axle torque are known to the controller exactly, as on no real rig."
    axles = case.train.axles
    if axles is not None and axles.simulated:
        yield (
            f"{len(axles.simulated)} of the train's {len(axles.positions)} axles are only simulated: nothing carries them, they "
            "neither pitch nor swing, and no coupling moves between vehicles. Numbers of axles are those of the "
            f"{len(axles.under_test)} under test; distance and deceleration are the train's."
        )
    if case.brake is not None or case.traction is not None or case.rig_control is not None:
        if all(getattr(sensor, "counts", 1.0) == 0.0 for sensor in (case.sensors.axles, case.sensors.rollers)):
            yield "The controllers see exact speeds: no encoder is modelled."
        yield "Motors follow their torque command with a linear lag, without electrical dynamics or heating."
    if case.slide_protection is not None or case.wheel_slip_control is not None:
        yield "Wheel slide protection (WSP) and wheel-slip control follow published principles and are no certified devices."
