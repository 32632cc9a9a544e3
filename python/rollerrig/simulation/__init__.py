"""AssembledModel -> [simulation] -> starting state, sensors, controllers and actuators, run -> Dataset."""
