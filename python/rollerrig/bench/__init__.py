"""The test bench: machines, sensors and controllers around a vehicle on rollers or track.

AssembledModel -> [bench] -> Dataset of a run with the bench's variables over `axle`
"""

from rollerrig.bench.bench_run import CONTROLLER_FAILED, ROLLERS_PROTECTED, BenchRun, users_controllers
from rollerrig.bench.controllers import COMMANDS, MEASUREMENTS, ControllerError

__all__ = [
    "COMMANDS",
    "CONTROLLER_FAILED",
    "MEASUREMENTS",
    "ROLLERS_PROTECTED",
    "BenchRun",
    "ControllerError",
    "users_controllers",
]
