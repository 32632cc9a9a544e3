"""A case as a functional mock-up unit, for Simulink, Dymola, FMPy and others.

Case -> assembled model -> [fmu: description, library that was built with the package] -> FILE.fmu
"""
