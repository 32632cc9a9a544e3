"""Does the bogie hunt on the rig? Let go 3 mm beside the middle at 160 and at 240 km/h."""

import rollerrig as rr

for speed in (160, 240):
    case = rr.load_case("bogie_rollers_constant").with_changes(
        {"motion.speed": f"{speed} km/h", "time.duration": "6 s"}
    )
    run = rr.simulate(case)  # an xarray.Dataset: named variables with units
    frame = run["lateral"].sel(body="front_frame")
    left = 1e3 * float(abs(frame.sel(time=slice(5.0, None))).max())
    print(f"{speed} km/h: {left:.2f} mm are left after 5 s, {run.attrs['status']}")

rr.save_run(run, "run.nc")  # NetCDF, with its configuration and its energy balance
rr.plot.motion_over_time(rr.load_run("run.nc")).savefig("motion.png")
