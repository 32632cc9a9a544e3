"""Reported numbers of the adhesion study, from the records of its ensembles.

records of track, rig and variants -> [adhesion numbers] -> numbers of summary.json, each explained in QUANTITIES
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from rollerrig.analysis.equivalent_dead_time import DeadTime
from rollerrig.analysis.slide_statistics import TestRecord
from rollerrig.study.adhesion_causes import is_within_error
from rollerrig.study.adhesion_laws import LAW_QUANTITIES
from rollerrig.study.ensemble import Estimate, distances, estimate, measure, relative
from rollerrig.study.quantities import Quantities, Quantity

PERCENT = ("%", 100.0)
RUN = (
    ("distance_m", "run by the train, on the rig by the virtual one", "m", "distance", None),
    ("duration_s", "time at the end of the test", "s", "duration", None),
    ("speed_end_kmh", "of the train at the end", "km/h", "speed at the end", None),
    ("mean_deceleration_mps2", "of the train since the demand, over the distance", "m/s^2", "mean deceleration", None),
    ("dump_cycles", "times that dump valves opened to vent, all axles under test", "1", "ventings", None),
    (
        "air_litres",
        "air at ambient pressure taken by the cylinders of the axles under test",
        "l",
        "air taken by the cylinders",
        None,
    ),
    ("mean_slip", "mean |wheel speed - train speed| over train speed, above 2 m/s", "1", "", PERCENT),
    ("largest_slip", "largest of the same", "1", "", PERCENT),
    ("longest_lock_s", "longest time that an axle turned slower than 5 % of the train", "s", "longest lock", None),
    (
        "regrip_adhesion",
        "largest |creep force| over static axle load on an axle that has slid",
        "1",
        "regrip force",
        None,
    ),
    ("adhesion_used_mean", "mean of |creep force| over static axle load under brake or traction", "1", "", None),
    ("adhesion_used_largest", "largest of the same", "1", "", None),
    (
        "reference_speed_error_rms_mps",
        "reference speed of the slide protection less the train's, RMS above 2 m/s; 0 without protection",
        "m/s",
        "reference speed error, RMS",
        None,
    ),
    ("reference_speed_error_largest_mps", "largest of the same", "m/s", "the same, largest", None),
    ("energy_relative_residual", "energy audit", "1", "residual of the energy audit", None),
)
RIG = (
    ("tracking_rms", "wheel less virtual wheel, over train speed, RMS", "1", "", PERCENT),
    ("tracking_largest", "largest of the same", "1", "", PERCENT),
    ("force_error_rms", "creep force less virtual force, RMS over RMS", "1", "force less virtual force", PERCENT),
    ("drive_ringing_nm", "fast torque that the virtual rail does not ask for, RMS, worst axle", "N m", "ringing", None),
    (
        "drive_limited_share",
        "part of the time with a drive's command at its limit",
        "1",
        "time at a drive's limit",
        PERCENT,
    ),
    (
        "drive_power_wanted_kw",
        "asked of a roller drive, before its limits",
        "kW",
        "power asked of a roller drive",
        None,
    ),
    ("drive_power_limited_s", "how long the limit of power held back a drive", "s", "time at a drive's power", None),
    ("crown_gravity_largest", "gravity on the crown over static axle load", "1", "gravity on the crown", PERCENT),
    ("real_sliding_largest_mps", "wheel against roller, largest", "m/s", "sliding on the roller, largest", None),
    ("real_sliding_rms_mps", "the same, RMS", "m/s", "the same, RMS", None),
    ("roller_torque_largest_nm", "of a roller drive", "N m", "torque of a roller drive, largest", None),
)
VARIANT = ("tracking_rms", "mean_slip", "dump_cycles", "air_litres")


def _of_ensembles(where: str, rows: Iterable[tuple[str, str, str, str, tuple[str, float] | None]]) -> list[Quantity]:
    found = []
    for name, meaning, unit, label, shown in rows:
        heading = label or " ".join(name.split("_"))
        key = f"{where}.{name}"
        found.append(Quantity(f"{key}.mean", f"{meaning}; mean of all starts", unit, heading, 4, shown))
        found.append(Quantity(f"{key}.standard_error", "of that mean", unit, "standard error", 2, shown))
    return found


QUANTITIES = Quantities(
    Quantity("case", "name of the case"),
    Quantity("starts", "tests in the ensembles of track and rig, which differ by up to 3 mm/s in their first speed", "1"),
    Quantity("verdict.*", "of tracking (wheel against virtual axle) and fidelity (rig against track): met, not met, not decided"),
    Quantity("verdicts.*.group", "tracking or fidelity"),
    Quantity("verdicts.*.verdict", "met: the whole interval is within the target; not met: nothing of it"),
    Quantity("verdicts.*.value", "mean over all starts; what is compared with the track is relative to it, a lock in s"),
    Quantity("verdicts.*.low", "lower end of its interval of 95 %"),
    Quantity("verdicts.*.high", "upper end"),
    Quantity("verdicts.*.target_low", "lower end of the target"),
    Quantity("verdicts.*.target_high", "upper end"),
    Quantity("verdicts.*.target_from", "where the target comes from"),
    Quantity("*.completed", "tests that came to their end", "1"),
    Quantity("*.stopped", "tests in which the train came to a stop", "1"),
    Quantity("*.status", "how the first test ended: on degraded track, and on the dry rig"),
    Quantity("*.status_message", "the same as a sentence"),
    _of_ensembles("*", RUN),
    _of_ensembles("rig", RIG),
    Quantity("variants.*.tests", "in the ensemble of a rig without some imperfections", "1"),
    Quantity("variants.*.distance_relative.mean", "mean distance over that of the track, less 1", "1", "distance", 2, PERCENT),
    Quantity("variants.*.distance_relative.standard_error", "of it", "1", "standard error", 2, PERCENT),
    Quantity("variants.*.*.mean", "tracking_rms, mean_slip, dump_cycles, air_litres as of the rig"),
    Quantity("variants.*.*.standard_error", "of it"),
    Quantity("causes.*.share", "part of (distance of rig over track, less 1)", "1", "share", 2, PERCENT),
    Quantity("causes.*.standard_error", "of it", "1", "standard error", 2, PERCENT),
    Quantity("causes.*.low", "lower end of its interval of 95 %", "1", "from", 2, PERCENT),
    Quantity("causes.*.high", "upper end", "1", "to", 2, PERCENT),
    Quantity("causes.*.within_its_error", "whether not even its sign is known"),
    LAW_QUANTITIES,
    Quantity("dead_time.predicted_s", "equivalent dead time of the rig in closed form, (D17): the sum of its parts", "s"),
    Quantity("dead_time.torque_s", "its part of the axle's torque that the virtual train takes", "s"),
    Quantity("dead_time.drive_s", "of the roller drives", "s"),
    Quantity("dead_time.least_s", "where wheels slide at constant adhesion, (Q8)", "s"),
    Quantity("dead_time.measured_s", "with how much more dead time of its protection the track has the rig's mean distance", "s"),
    Quantity("dead_time.standard_error_s", "of it", "s"),
    Quantity("dead_time.low_s", "lower end of its interval of 95 %", "s"),
    Quantity("dead_time.high_s", "upper end", "s"),
    Quantity("dead_time.track.*.*", "by additional dead time in ms: mean distance [m] on track, its standard error, ventings"),
    Quantity("point_by_point.*.wheel_speed_rms", "wheel less wheel on track, over train", "1", "wheel speed, RMS", 2, PERCENT),
    Quantity("point_by_point.*.wheel_speed_largest", "largest of the same", "1", "wheel speed, largest", 2, PERCENT),
    Quantity("point_by_point.*.train_speed_largest_mps", "train less train on track, largest", "m/s"),
    Quantity("point_by_point.*.slip_difference_rms", "slip less slip on track, RMS", "1", "slip, RMS", 2, PERCENT),
    Quantity("point_by_point.*.torque_difference_rms_nm", "brake and traction torque, less that on track, RMS", "N m"),
    Quantity("tracking_by_own_motion", "part of its variance in proportion to the wheelsets' own motion, (D14)", "1"),
)  # fmt: skip


def run_numbers(records: Sequence[TestRecord], *, rig: bool) -> dict[str, Any]:
    """Of the ensemble of track or rig."""
    names = [row[0] for row in (*RUN, *(RIG if rig else ()))]
    first = records[0]
    return {
        "status": first.status,
        "status_message": first.message,
        "completed": sum(record.completed for record in records),
        "stopped": sum(record.stopped for record in records),
        **{name: measure(records, name).as_dict() for name in names},
    }


def variant_numbers(track: Sequence[TestRecord], records: Sequence[TestRecord]) -> dict[str, Any]:
    """Of the ensemble of a variant of the rig."""
    on_track, own = (estimate(values) for values in distances((track, records)))
    found = {name: measure(records, name).as_dict() for name in VARIANT}
    return {"tests": len(records), "distance_relative": relative(own, on_track).as_dict(), **found}


def cause_numbers(shares: Mapping[str, Estimate] | None) -> dict[str, Any]:
    """Of the causes; empty where they were not asked for."""
    return {
        name: {
            "share": share.mean,
            "standard_error": share.standard_error,
            "low": share.interval.low,
            "high": share.interval.high,
            "within_its_error": is_within_error(share),
        }
        for name, share in (shares or {}).items()
    }


def dead_time_numbers(
    predicted: DeadTime | None, measured: Estimate | None, track: Mapping[float, Sequence[TestRecord]]
) -> dict[str, Any]:
    """Of the equivalent dead time; empty where nothing is predicted."""
    if predicted is None:
        return {}
    found: dict[str, Any] = {
        "predicted_s": predicted.total,
        "torque_s": predicted.torque,
        "drive_s": predicted.drive,
        "least_s": predicted.least,
    }
    if measured is not None:
        interval = measured.interval
        found |= {"measured_s": measured.mean, "standard_error_s": measured.standard_error}
        found |= {"low_s": interval.low, "high_s": interval.high}
    for delay, records in track.items():
        one = measure(records, "distance_m")
        found.setdefault("track", {})[f"{1e3 * delay:g}"] = {
            "distance_m": one.mean,
            "standard_error_m": one.standard_error,
            "dump_cycles": measure(records, "dump_cycles").mean,
        }
    return found
