"""Is a vehicle safe in a curve of 600 m at 100 km/h? Y/Q of its wheels against Nadal's limit."""

import rollerrig as rr

run = rr.simulate(rr.load_case("vehicle_curve"))
forces = rr.wheel_forces(run)
quotient = forces["derailment_quotient"]
worst = quotient.max("time")
wheel = str(worst.idxmax("wheel").to_numpy())
print(f"largest Y/Q: {float(worst.max()):.2f} at {wheel}; Nadal's limit {float(forces['nadal_limit']):.2f}")
print(f"least wheel load: {1e-3 * float(forces['wheel_load'].min()):.1f} kN")
rr.plot.quotient(forces).savefig("quotient.png")
