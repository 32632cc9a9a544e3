"""Does a locomotive's bogie have the adhesion that was measured on a Siemens Eurosprinter? On track, at 36 km/h."""

import numpy as np

import rollerrig as rr

# Means of measured points: creepage [%], traction coefficient (Engel, Beck, Alders 1998; docs/measured.md).
MEASURED = {0.499: 0.2505, 0.897: 0.2784, 1.465: 0.2964, 2.873: 0.3041, 5.954: 0.2968, 10.367: 0.2458, 18.990: 0.2108}

case = rr.load_case("eurosprinter_traction")
run = rr.simulate(case)
axle = run.sel(axle="wheelset_1", body="wheelset_1", wheel=["wheelset_1_left", "wheelset_1_right"])
train = run["train_speed"] + axle["longitudinal_velocity"]  # the bogie yields on its traction rod
sliding = case.vehicle.data.wheel.radius * axle["axle_speed"] - train
slip = 100 * (sliding / run["train_speed"]).to_numpy()
traction = (axle["creep_force"] / axle["vertical_force"].sum("wheel")).to_numpy()
until = int(np.argmax(slip > 20.0)) + 1  # then the wheels run away
for creepage, measured in MEASURED.items():
    here = float(np.interp(creepage, slip[:until], traction[:until]))
    print(f"{creepage:5.1f} %: measured {measured:.3f}, here {here:.3f}, error {here - measured:+.3f}")
