"""A test at full scale and on models of it as numbers: the runs by name, what is reported of them, and how tables show it."""

from __future__ import annotations

from rollerrig.study.quantities import Quantities, Quantity
from rollerrig.study.scale_tables import VIOLATION

LABELS = {
    "full": "full scale",
    "model": "the model as it is",
    "ideal": "ideal: everything scaled",
    "gravity": "gravity alone not scaled",
    "material": "material alone not scaled",
    "clock": "controllers' clock alone not scaled",
    "drives": "bandwidth of the drives alone not scaled",
    "own": "the model's own actuators alone",
}

PERCENT = ("%", 100.0)
RUN = (
    Quantity("*.status", "how the run ended: at full scale, and that of the model mapped back"),
    Quantity("*.status_message", "the same as a sentence"),
    Quantity("*.duration_s", "end of the test", "s", "end of the test"),
    Quantity("*.wheel_load_n", "mean wheel load at the start", "N", "mean wheel load", shown=("kN", 1e-3)),
    Quantity("*.lateral_largest_m", "largest lateral displacement of a wheelset", "m",
             "lateral displacement of a wheelset, largest", shown=("mm", 1e3)),
    Quantity("*.stopped", "whether the train came to a stop before the end of the run", "", "came to a stop"),
    Quantity("*.distance_m", "run by the train", "m", "distance"),
    Quantity("*.speed_end_kmh", "of the train at the end", "km/h", "speed at the end"),
    Quantity("*.wheel_slip_largest", "largest |wheel speed - train speed| over train speed, above 2 m/s", "1",
             "slip against the train, largest", 3, PERCENT),
    Quantity("*.tracking_rms", "RMS of wheel speed less that of the virtual train, over train speed; null: none", "1",
             "tracking error, RMS", 3, PERCENT),
    Quantity("*.real_sliding_largest_mps", "wheel against roller", "m/s", "real sliding, largest", 3, ("mm/s", 1e3)),
    Quantity("*.axle_torque_largest_nm", "of brake and traction on one axle", "N m", "torque on an axle, largest",
             shown=("kN m", 1e-3)),
    Quantity("*.dump_cycles", "times that dump valves opened to vent, all axles", "", "dump cycles, all axles"),
    Quantity("*.linear_critical_speed_kmh", "with speed-controlled rollers; null: none from 40 to 520 km/h", "km/h",
             "linear critical speed"),
)  # fmt: skip
FIDELITY = (
    Quantity("fidelity.lateral_rms_m", "wheelsets of the model mapped back less full scale at the same time, RMS", "m",
             "lateral displacement, RMS", 3, ("mm", 1e3)),
    Quantity("fidelity.wheel_speed_rms", "the same of wheel speeds over the train's highest speed, RMS", "1", "wheel speed, RMS",
             3, PERCENT),
    Quantity("fidelity.wheel_speed_largest", "largest of the same", "1", "wheel speed, largest", 3, PERCENT),
    Quantity("fidelity.train_speed_largest_mps", "the same of the train", "m/s", "train speed, largest", 3),
    Quantity("fidelity.distance_relative", "distance over that at full scale, less 1", "1", "distance", 3, PERCENT),
    Quantity("fidelity.linear_critical_speed_relative", "linear critical speed over that at full scale, less 1", "1",
             "linear critical speed", 3, PERCENT),
)  # fmt: skip
CONTACT = (
    Quantity("contact.*.wheel_load", "first wheel in steady running, each at its own scale", "N"),
    Quantity("contact.*.semi_axis", "sqrt(a b) of its largest patch", "m"),
    Quantity("contact.*.pressure", "largest in it", "Pa"),
    Quantity("contact.*.roller_share", "semi-axis over the roller's radius", "1"),
)
QUANTITIES = Quantities(
    Quantity("case", "name of the full-scale case"),
    Quantity("model", "name of its model"),
    Quantity("similitude.**", "strategy, factors full/model, and what was not scaled"),
    RUN,
    FIDELITY,
    Quantity("error_budget.*.*", "the same numbers of the ideal model, and of models with one violation each"),
    *(Quantity(f"violations.*.{key}", meaning) for key, meaning in VIOLATION.items()),
    CONTACT,
    Quantity("motor_limited_share", "part of the time in which a motor of the model is at its limit; null: no limit", "1"),
)  # fmt: skip
