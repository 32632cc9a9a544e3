"""How much lower is the linear critical speed of a bogie on the rig than on track, and with which roller radius?"""

import rollerrig as rr

speeds = range(160, 400, 20)  # km/h
track = rr.critical_speed("bogie_track", speeds_kmh=speeds)["linear_critical_speed"]
print(f"on track: {float(track):.1f} km/h")

for radius in (0.5, 0.725, 2.0):
    case = rr.load_case("bogie_rollers_constant").with_changes({"support.roller_radius": radius})
    rig = rr.critical_speed(case, speeds_kmh=speeds)["linear_critical_speed"]
    print(f"on rollers of {radius:g} m: {float(rig):.1f} km/h")

modes = rr.stability("bogie_rollers_constant", speeds_kmh=range(60, 301, 20))
rr.plot.damping_over_speed(modes).savefig("damping.png")
