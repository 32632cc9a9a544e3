"""The whole vehicle on irregular track against its linearised model: the response spectrum, line by line.

A small irregularity excites the vehicle at the harmonics of the rails' period. The linear answer is made here, from the
Jacobian and the influence of one rail's displacement and slope under one wheel at a time: the delays between the wheels
are put in by hand, none of the core's own track is used but those influences.
"""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import rollerrig as rr
from rollerrig import _core
from rollerrig.analysis.modes import Lineariser
from rollerrig.assembly.model import AssembledModel, assemble
from rollerrig.config import Case
from rollerrig.irregularity import RAILS, RailIrregularity

SPEED, PERIOD = 40.0, 320.0
SAMPLES = 2000  # per period
SHORTEST = 6.0  # m: 6.7 Hz, well resolved by the samples; the bogies' modes are below 12 Hz


def case() -> Case:
    """Three periods, so that the last one is free of how it began; as soft a start as can be had.

    Normal damping acts on approach only, which no linear model knows.
    """
    return rr.load_case("vehicle_track_irregular").with_changes(
        {
            "motion.speed_mps": SPEED,
            "support.irregularity": {
                "kind": "ore_b176", "level": "low", "seed": 4, "scale": 1e-3, "period": PERIOD, "fade_in": 100.0,
                "shortest_wavelength": SHORTEST,
            },
            "contact.normal_damping": 0.0,
            "time.duration": 3 * PERIOD / SPEED,
            "time.step": "0.64 ms",
            "time.output_step": PERIOD / SPEED / SAMPLES,
        }
    )  # fmt: skip


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    return rr.simulate(case())


def influence(model: AssembledModel, state: np.ndarray, wheel: int, rail: str, derivative: int) -> np.ndarray:
    """Change of x' per displacement (0) or slope (1) of one rail under one wheel."""
    size, step, period = 1e-7, 0.25, 64.0  # small: profiles have knots
    tables = {name: np.zeros((int(period / step), 4)) for name in RAILS}
    along = model.positions[model.wheels[wheel].wheelset][0]
    row = int(np.mod(along, period) / step)
    changed = {sign: {**tables, rail: tables[rail].copy()} for sign in (-1.0, 1.0)}
    late = period / SPEED  # one period on, so that every wheel has passed where it fades in
    rates = []
    for sign, table in changed.items():
        # the displacement belongs to the wheel itself: the slope acts about it
        table[rail][row, derivative] = sign * size
        if derivative:
            table[rail][row, 0] = -sign * size * (np.mod(along, period) - row * step)
        rails = {name: _core.UniformSpline(0.0, step, table[name]) for name in RAILS}
        model.parts["irregularity"] = _core.Irregularity(period=period, fade_in=0.0, steered=True, **rails)
        rates.append(_core.Simulation(model.finish().core).derivative(late, state)[0])
    return (rates[1] - rates[0]) / (2 * size)


def linear_response(rails: RailIrregularity) -> tuple[np.ndarray, np.ndarray]:
    """Angular frequencies and complex amplitudes of all states' rates, (harmonics, states)."""
    without = case().with_changes({"support.irregularity": None})
    linear = Lineariser(without).at(SPEED)
    model = AssembledModel(without)
    knots = np.arange(4096) * rails.period / 4096
    k = np.arange(3, int(PERIOD / SHORTEST) + 1)  # from 100 m on
    wavenumber = 2 * np.pi * k / rails.period
    omega = SPEED * wavenumber
    forcing = np.zeros((len(k), linear.matrix.shape[0]), dtype=complex)
    for number, wheel in enumerate(model.wheels):
        delay = np.exp(1j * wavenumber * model.positions[wheel.wheelset][0])
        for axis in "yz":
            rail = f"{wheel.side}_{axis}"
            wave = np.fft.rfft(rails.evaluate(rail, knots))[k] / len(knots) * 2 * delay
            for derivative, factor in ((0, 1.0), (1, 1j * wavenumber)):
                effect = influence(model, linear.equilibrium, number, rail, derivative)
                forcing += np.outer(wave * factor, effect)
    states = np.array(
        [
            np.linalg.solve(1j * w * np.eye(len(linear.matrix)) - linear.matrix, f)
            for w, f in zip(omega, forcing, strict=True)
        ]
    )
    return omega, 1j * omega[:, None] * states


TOLERANCES = {
    # The third power of the displacement, what the first two periods left behind, and kinks of the strips in the lateral ones.
    ("car_body", "lateral"): 1e-3,
    ("car_body", "vertical"): 1e-3,
    ("front_frame", "lateral"): 1e-3,
    ("front_frame", "vertical"): 1e-3,
    ("wheelset_1", "lateral"): 1e-3,
    # rk4 at 0.64 ms follows a wheel on its stiff contact to 1 %; at half the step to 0.1 %.
    ("wheelset_1", "vertical"): 2e-2,
}
"""Of the norm over all lines of the complex difference: phases count as much as amplitudes."""


@pytest.mark.slow
def test_the_response_spectrum_is_that_of_the_linearised_model(run: xr.Dataset) -> None:
    model = assemble(case())
    assert model.irregularity is not None
    omega, accelerations = linear_response(model.irregularity)
    rate_index = _core.Simulation(model.core).rate_index
    lines = np.round(omega / (2 * np.pi) * PERIOD / SPEED).astype(int)
    last = run.isel(time=slice(2 * SAMPLES, 3 * SAMPLES))
    for (body, variable), tolerance in TOLERANCES.items():
        signal = last[f"{variable}_acceleration"].sel(body=body).to_numpy()
        found = np.fft.rfft(signal)[lines] / SAMPLES * 2
        direction = {"lateral": 1, "vertical": 2}[variable]
        expected = accelerations[:, rate_index[model.body_index(body)][direction]]
        assert np.linalg.norm(found - expected) < tolerance * np.linalg.norm(expected), (body, variable)
        other = np.delete(np.abs(np.fft.rfft(signal))[: lines[-1]], lines[:-1]) / SAMPLES * 2
        assert np.linalg.norm(other) < 1e-2 * np.linalg.norm(expected), "power where the rails have none"


def test_same_seed_same_bytes_of_a_whole_run() -> None:
    short = rr.load_case("vehicle_track_irregular").with_changes({"time.duration": "0.4 s"})
    first, again = rr.simulate(short), rr.simulate(short)
    other = rr.simulate(short.with_changes({"support.irregularity.seed": 2}))
    assert first["vertical_force"].to_numpy().tobytes() == again["vertical_force"].to_numpy().tobytes()
    assert np.abs(first["vertical_force"] - other["vertical_force"]).max() > 100.0  # N


@pytest.mark.slow
def test_rails_on_a_stiff_foundation_are_rigid_rails() -> None:
    """What an elastic rail adds to the wheel forces goes with 1 / stiffness; ten times stiffer, it is seven times less."""
    base = rr.load_case("vehicle_track_irregular").with_changes(
        {
            "vehicle.cut": "leading_wheelset",
            "vehicle.body.car_body.locked": [],
            "support.irregularity.scale": 0.05,
            "time.duration": "0.6 s",
            "contact.normal": "hertz",
            "contact.creep": "kalker_saturated",
            "time.method": "rk4",
            "time.step": "0.02 ms",
        }
    )
    rigid = rr.simulate(base)["vertical_force"]
    errors = []
    for stiffness in (1e9, 1e10):
        support = {"stiffness": stiffness, "damping": 1e-4 * stiffness}
        foundation = {"rail_mass": 60.0, "lateral": support, "vertical": support}
        elastic = rr.simulate(base.with_changes({"support.foundation": foundation}))
        assert elastic.attrs["energy_relative_residual"] < 1e-8
        errors.append(float(np.sqrt(((elastic["vertical_force"] - rigid) ** 2).mean())))
    assert errors[1] < 0.2 * errors[0]
    assert errors[1] < 0.01 * float(rigid.std())
