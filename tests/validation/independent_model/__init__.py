"""An independent copy of the physics, in NumPy, that the simulator is checked against.

Nothing here is imported from the simulator, and nothing in the simulator is imported from here: the same equations stand
here a second time, on purpose. The benchmarks time the same model.

    parameters    profiles, masses, springs and material of the bogie on the full-scale rig
    kalker_table  Kalker's coefficients as literal numbers
    contact       wheel-roller contact: geometry, Hertz, Kalker, saturation
    bogie         right-hand side, equilibrium and outputs of the bogie
    conicity      rolling radius difference and equivalent conicity of two profiles, EN 15302
"""
