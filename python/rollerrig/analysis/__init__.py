"""Stability of rolling: modes over speed, critical speeds, limit cycles; and what engineers read off a run.

Case -> [Lineariser -> modes -> speed map -> critical, stability]   small motions, exact derivatives
     -> [hunting, ramp -> signals]          runs from a disturbance
     -> [limit cycle runs -> limit cycle]   what is left at each speed, stepped up and down
run  -> [wheel_rail_forces, ride -> filters]         wheel forces, Y/Q, wear number, accelerations, as EN 14363 assesses them
"""

SPEEDS_KMH = tuple(float(v) for v in range(60, 301, 20))
"""Speeds of a stability analysis unless others are given [km/h]."""
