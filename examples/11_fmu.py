"""Can a loop be closed around the rig in another tool? Here FMPy; Simulink takes the same file."""

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave
from fmpy.validation import validate_fmu

import rollerrig as rr

# The bench without its own slide protection: the valves are inputs, what the sensors read are outputs.
path = rr.export_fmu("adhesion_brake", "bench.fmu", external=["slide_protection"])
print(f"validation: {validate_fmu(str(path)) or 'nothing to say'}")

description = fmpy.read_model_description(str(path))
reference = {variable.name: variable.valueReference for variable in description.modelVariables}
valves = [reference[f"wheelset_{i}.valve_command"] for i in (1, 2)]
axles = [reference[f"slide_protection.wheelset_{i}.axle_speed"] for i in (1, 2)]
train, pressure = reference["train.speed"], reference["wheelset_1.cylinder_pressure"]

rig = FMU2Slave(
    guid=description.guid,
    unzipDirectory=fmpy.extract(str(path)),
    modelIdentifier=description.coSimulation.modelIdentifier,
)
rig.instantiate()
rig.setupExperiment(startTime=0.0)
rig.enterInitializationMode()
rig.exitInitializationMode()

radius, step, slips, vented = 0.46, 0.005, [], 0
for k in range(1600):
    speed, *turning = rig.getReal([train, *axles])
    slip = 1.0 - radius * np.array(turning) / speed
    command = np.where(slip > 0.15, 2.0, np.where(slip > 0.08, 1.0, 0.0))  # vent, hold, fill
    rig.setReal(valves, list(command))
    rig.doStep(k * step, step)
    slips.append(slip.max())
    vented += int((command == 2.0).any())
print(f"after {1600 * step:g} s: {3.6 * rig.getReal([train])[0]:.1f} km/h, {rig.getReal([pressure])[0] / 1e5:.2f} bar")
print(f"largest slip {100 * max(slips):.0f} %, vented in {vented} of 1600 steps")
rig.terminate()
rig.freeInstance()
