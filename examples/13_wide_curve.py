"""What do gauge widening and a worn outer rail change in a curve of 190 m? Guiding forces and wear of the leading wheelset."""

import numpy as np

import rollerrig as rr

# Points of a worn head, gauge side at negative y: 60E1 1:40 less 1 mm on the crown, 1.5 mm in the gauge corner.
y, height = np.array(rr.profile("en_60e1_1_40").attrs["outline"]).T
worn = height - 1e-3 * np.exp(-((y / 22e-3) ** 4)) - 1.5e-3 * np.exp(-(((y + 28e-3) / 8e-3) ** 2))
np.savetxt("worn_rail.txt", 1e3 * np.column_stack([y, worn]), fmt="%.5f")

case = rr.load_case("vehicle_curve").with_changes(
    {"support": {"use": "curved_track_190"}, "motion.speed": "45 km/h", "time.duration": "16 s"}
)
curve = "support.segment[2]"
variants = {
    "1445 mm, new rails": {},
    "1435 mm, new rails": {f"{curve}.gauge": "1435 mm"},
    "1445 mm, right rail worn": {"support.right_profile": "worn_rail.txt"},
}
for name, change in variants.items():
    forces = rr.wheel_forces(rr.simulate(case.with_changes(change))).sel(time=slice(12.0, None))
    guiding = float(abs(forces["guiding_force"].sel(wheel="wheelset_1_right")).mean())
    wear = float(forces["wear_number"].sel(wheel=["wheelset_1_left", "wheelset_1_right"]).sum("wheel").mean())
    print(f"{name}: Y of the leading outer wheel {1e-3 * guiding:.1f} kN, wear number of its wheelset {wear:.0f} N")
