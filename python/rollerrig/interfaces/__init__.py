"""The rig for other programs: a plant with named inputs and outputs, FMUs, a server in real time, Gymnasium."""
