"""Which forces does the log of a rig hold, and do its sensors agree? A pressure sensor that reads 10 % too much."""

import rollerrig as rr

case = rr.load_case("adhesion_brake").with_changes({
    "contact.normal": "hertz",
    "motion.speed": "60 km/h",
    "brake.demand": [[0.0, "0 bar"], ["0.1 s", "3.8 bar"]],
    "time.duration": "3.5 s",
    "time.output_step": "1 ms",
})  # fmt: skip
log = rr.simulate(case)[
    ["axle_speed", "roller_speed", "roller_torque", "cylinder_pressure", "creep_force", "train_speed"]
]
log["cylinder_pressure"].values *= 1.1
rr.export(log, "rig.csv")

found = rr.replay(case, "rig.csv")
print(found.summary)
for name, axle in found.numbers["axles"].items():
    print(f"{name}: torque by drive and speeds {axle['torque_ratio']:.3f} times that by pressure")
    print(
        f"{name}: force off by {axle['error_at_once_n']:.0f} N at the instant, {axle['error_n']:.0f} N without the delay"
    )
found.write("replay", force=True)
