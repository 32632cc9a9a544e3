"""Checks that a run ends: numbers kept, steps integrated, rail remembered. Each key may be in its range and their product not.

Case -> [check_size] -> problems that say which key to change, before anything is computed
"""

from collections.abc import Iterator

from rollerrig import _core
from rollerrig.config.errors import ConfigProblem
from rollerrig.config.schema.case import CaseTables

MOST_NUMBERS = 2e9
"""Results of one run: 16 GB."""
MOST_STEPS = 1e9
"""Largest number of steps of a fixed-step method: hours for a wheelset, days for a vehicle."""


def check_size(case: CaseTables, file: str) -> Iterator[ConfigProblem]:
    """Runs that would not fit into memory, or not end within days; rail that is forgotten before all wheels have passed."""
    yield from _results(case, file)
    yield from _steps(case, file)
    yield from _rail(case, file)


def numbers_per_sample(case: CaseTables) -> int:
    """About how many numbers a run keeps at each output time."""
    part = case.vehicle.part
    bodies = case.vehicle.data.bodies_in(part)
    axles = sum(body.kind == "wheelset" for body in bodies)
    of_a_wheel = len(_core.wheel_fields) + _core.patches_recorded * len(_core.patch_fields)
    return (
        (len(bodies) + len(part.fixed) + 2 * axles) * len(_core.body_fields)
        + 2 * axles * of_a_wheel
        + len(case.vehicle.data.elements_in(part)) * len(_core.element_fields)
        + (max(axles, _train_axles(case)) * len(_core.axle_fields) if case.sampled else 0)
    )


def _train_axles(case: CaseTables) -> int:
    return len(case.train.axles.positions) if case.train.axles else 0


def _results(case: CaseTables, file: str) -> Iterator[ConfigProblem]:
    duration, step = case.time.duration, case.time.output_step
    width = numbers_per_sample(case)
    if width * duration / step > MOST_NUMBERS:
        least = width * duration / MOST_NUMBERS
        allowed = (
            f"too many results: {duration / step:.3g} samples of {width} numbers are {8e-9 * width * duration / step:.3g} GB; "
            f"allowed for {duration:g} s: at least {1e3 * least:.3g} ms, or a shorter time.duration"
        )
        yield ConfigProblem(file, "time.output_step", f"{1e3 * step:g} ms", allowed)


def _steps(case: CaseTables, file: str) -> Iterator[ConfigProblem]:
    duration, own = case.time.duration, case.integration
    asked = {
        "step": own.step if own.fixed else None,
        "maximum_step": case.time.maximum_step,
        "sampling_step": case.time.sampling_step if case.sampled else None,
    }
    for key, step in asked.items():
        if step is not None and duration / step > MOST_STEPS:
            allowed = (
                f"{duration / step:.3g} steps would take days; allowed for {duration:g} s: at least "
                f"{1e3 * duration / MOST_STEPS:.3g} ms, or a shorter time.duration"
            )
            yield ConfigProblem(file, f"time.{key}", f"{1e3 * step:g} ms", allowed)


def _rail(case: CaseTables, file: str) -> Iterator[ConfigProblem]:
    """The rail that is remembered must reach from the first wheelset to the last, or the following wheels find it as it was."""
    adhesion = case.adhesion
    if adhesion is None or not adhesion.recovery_constant:
        return
    places = [b.position[0] for b in case.vehicle.data.bodies_in(case.vehicle.part) if b.kind == "wheelset"]
    least = (max(places) - min(places)) / (_core.rail_cells - 2)
    if adhesion.cell_length < least:
        allowed = (
            f"allowed: at least {1e3 * least:.3g} mm: {_core.rail_cells} cells are kept, and the wheelsets stand "
            f"{max(places) - min(places):.4g} m apart"
        )
        yield ConfigProblem(file, "adhesion.cell_length", f"{1e3 * adhesion.cell_length:g} mm", allowed)
