"""Is a vehicle safe in a curve of 600 m at 100 km/h? Y/Q of its wheels, filtered as EN 14363 asks, against Nadal's limit."""

import rollerrig as rr
from rollerrig.analysis.wheel_rail_forces import filtered

run = rr.simulate(rr.load_case("vehicle_curve"))
forces = rr.wheel_forces(run)  # unfiltered
assessed = filtered(forces)  # 20 Hz, means over 2 m
worst = assessed["derailment_quotient"].max("time")
wheel = str(worst.idxmax("wheel").to_numpy())
print(f"largest Y/Q: {float(worst.max()):.2f} at {wheel}; Nadal's limit {float(forces['nadal_limit']):.2f}")
least, raw = (1e-3 * float(one["wheel_load"].min()) for one in (assessed, forces))
print(f"least wheel load: {least:.1f} kN; raw {raw:.1f} kN")
rr.plot.quotient(assessed).savefig("quotient.png")
