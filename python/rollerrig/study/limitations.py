"""What the model of a case leaves out: sentences that follow from the case.

Case -> [limitations] -> sentences for the report
"""

from rollerrig.config import Case, Rig
from rollerrig.config.schema.contact import KalkerLinear, KalkerSaturated


def limitations(case: Case) -> list[str]:
    """What the model of this case leaves out, a sentence each."""
    found = (*_structure(case), *_contact(case), *_actuators(case))
    return [sentence for holds, sentence in found if holds]


Sentence = tuple[object, str]  # whether it holds, and what it says


def _structure(case: Case) -> tuple[Sentence, ...]:
    support, fixed = case.support.data, ", ".join(name.replace("_", " ") for name in case.vehicle.part.fixed)
    on_rig, uneven = isinstance(support, Rig), support.irregularity
    elastic = (support.mounting if isinstance(support, Rig) else support.foundation) is not None
    measured, shortest = getattr(uneven, "kind", "") == "file", getattr(uneven, "shortest_wavelength", 0.0)
    return (
        (True, "Car bodies, frames and wheelsets are rigid."),
        (fixed, f"Fixed, as on a test rig: {fixed}."),
        (on_rig and not elastic, "The rollers are rigid and their axles only spin in rigid bearings."),
        (on_rig and elastic, "The rollers are rigid; their axles stand on linear springs and dampers."),
        (not on_rig and not elastic, "The rails are rigid and do not move."),
        (not on_rig and elastic, "The rails are rigid; the piece below each wheel stands on linear springs and dampers, and "
                                 "pieces do not interact."),
        (uneven is None and on_rig, "The rollers are perfectly round, and profiles do not wear."),
        (uneven is None and not on_rig, "The track is free of irregularities, and profiles do not wear."),
        (measured, "Irregularities are those of the measured file, no shorter than its sampling resolves; profiles do not wear."),
        (uneven is not None and not measured,
         "Irregularities are one realisation of a stationary spectrum without wavelengths below "
         f"{shortest:g} m; profiles do not wear."),
        (uneven is not None and on_rig,
         "The actuators follow the irregularity exactly; the rollers themselves are perfectly round."),
    )  # fmt: skip


def _contact(case: Case) -> tuple[Sentence, ...]:
    contact, rail = case.contact, case.adhesion
    kalker = isinstance(contact.creep, KalkerLinear | KalkerSaturated)
    off = ", ".join(name for name, on in contact.roller_effects.model_dump().items() if not on)
    recovers = rail is not None and rail.recovery_constant > 0.0
    recovery = "recovers by the dissipated energy alone" if recovers else "is not changed by sliding"
    return (
        (True, contact.normal.limitation),
        (True, f"{contact.creep.limitation} Rolling contact is quasi-steady: each patch has its steady force at once."),
        (kalker and not getattr(contact.creep, "saturate_spin_moment", False), "The spin moment is not limited by friction."),
        (off and isinstance(case.support.data, Rig), f"Switched off, unlike on a real rig: the rollers' effect of {off}."),
        (rail is None, contact.friction.limitation),
        (rail is not None, "The adhesion of the rail depends on place or time and on the slip velocity as given, without "
                           f"temperature, and {recovery}."),
    )  # fmt: skip


def _actuators(case: Case) -> tuple[Sentence, ...]:
    control, axles, sensors = case.rig_control, case.train.axles, (case.sensors.axles, case.sensors.rollers)
    what = "rollers' speed is" if isinstance(case.support.data, Rig) else "running speed is"
    transfer = "no load transfer" if control and control.load_transfer == "none" else "quasi-static load transfer"
    simulated, listed, tested = (len(getattr(axles, name, ())) for name in ("simulated", "positions", "under_test"))
    driven = case.brake is not None or case.traction is not None or control is not None
    exact = all(getattr(sensor, "counts", 1.0) == 0.0 for sensor in sensors)
    return (
        (case.motion.drive == "speed_controlled" and control is None,
         f"The {what} prescribed: no drive reacts to the contact forces."),
        (case.contact.pure_rolling, "Wheels roll on the rollers without longitudinal sliding (pure-rolling assumption)."),
        (control, "The virtual train runs straight ahead on centred wheels with one elliptical patch each: no lateral motion, no "
                  f"spin, {transfer}."),
        (control and control.estimator.kind == "exact",
         "Contact force and axle torque are known to the controller exactly, as on no real rig."),
        (simulated, f"{simulated} of the train's {listed} axles are only simulated: nothing carries them, they neither pitch nor "
                    "swing, and no coupling moves between vehicles. Numbers of axles are those of the "
                    f"{tested} under test; distance and deceleration are the train's."),
        (driven and exact, "The controllers see exact speeds: no encoder is modelled."),
        (driven, "Motors follow their torque command with a linear lag, without electrical dynamics or heating."),
        (case.slide_protection is not None or case.wheel_slip_control is not None,
         "Wheel slide protection (WSP) and wheel-slip control follow published principles and are no certified devices."),
    )  # fmt: skip
