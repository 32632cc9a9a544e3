"""Does our slide protection, exported as an FMU and brought back in, brake the train as the built-in one does?"""

from pathlib import Path

import rollerrig as rr

case = rr.load_case("adhesion_brake").with_changes({"time.duration": "8 s"})
path = rr.export_part(case, "slide_protection", "wsp.fmu")
built_in = rr.simulate(case)
# Another tool's FMU has other names: `names` says which of its variables is which of our signals.
names = {"axle_speed": "{axle}.axle_speed", "valve": "{axle}.valve_command"}
with_fmu = rr.simulate(
    case.with_changes({"slide_protection.fmu": {"file": str(Path(path).absolute()), "names": names}})
)

print("it took part:", with_fmu.attrs["slide_protection_fmu"].partition(", SHA")[0])
for name, run in (("built in", built_in), ("as an FMU", with_fmu)):
    vented = int((run["valve"] == 2.0).any("axle").sum())
    print(
        f"{name}: {run['train_distance'].values[-1]:.3f} m in 8 s, vented in {vented} of {run.sizes['time']} instants"
    )
same = all(
    (built_in[name] == with_fmu[name]).all() for name in ("axle_speed", "cylinder_pressure", "valve", "train_speed")
)
print(f"the same numbers: {bool(same)}")
