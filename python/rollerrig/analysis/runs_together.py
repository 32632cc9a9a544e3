"""Signals of several runs on one axis, and by how much each differs from the first run's.

runs by name, names of signals -> [compare_runs] -> Dataset -> picture, table

A signal is a variable of a run, and where it has one value for each body, wheel, element or axle, the one that is meant:
`speed`, `lateral:wheelset_1`, `vertical_force:wheelset_1_left`.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from rollerrig.config.errors import nearest
from rollerrig.results import RunInfo

STEADY = 1e-3  # a speed that changes by no more than this part is not shown unless asked for


def compare_runs(runs: Mapping[str, xr.Dataset], signals: Sequence[str] = ()) -> xr.Dataset:
    """Signals of several runs over the time that all of them have.

    Args:
        runs: name -> results of `simulate` or `load_run`; the first one is what the others are compared with.
        signals: see the module's text; none: speed, and lateral motion and forces of the foremost wheelset.

    Returns:
        A variable per signal over `run` and `time` [s], at the first run's times; `<signal> largest difference` over `run`.

    Raises:
        ValueError: no runs by name, fewer than two, results of something else, a signal that one of them does not have, or no
            common time.

    Example:
        >>> import rollerrig as rr
        >>> case = rr.load_case("wheelset_rollers").with_changes({"time.duration": "0.05 s"})
        >>> runs = {"dry": rr.simulate(case), "wet": rr.simulate(case.with_changes({"contact.friction": 0.1}))}
        >>> float(compare_runs(runs, ["speed"])["speed largest difference"].sel(run="wet"))
        0.0
    """
    given: object = runs
    if isinstance(given, xr.Dataset) or not isinstance(given, Mapping):
        raise ValueError("compare_runs takes runs by name: compare_runs({'rig': run, 'track': other})")
    if len(runs) < 2:
        raise ValueError(f"{len(runs)} run; needed: two or more")
    for label, run in runs.items():
        if (
            run.get("time", run).dims != ("time",)
            or run.sizes["time"] < 2
            or "speed" not in run
            or "wheel" not in run.sizes
        ):
            raise ValueError(f"{label}: no run over time; needed: results of a run, such as its run.nc")
    first = next(iter(runs.values()))
    end = min(float(run["time"][-1]) for run in runs.values())
    times = first["time"].to_numpy()
    times = times[times <= end * (1 + 1e-12)]
    if len(times) < 2:
        raise ValueError("the runs have no time in common")
    found: dict[str, xr.DataArray] = {}
    for name in signals or telling_signals(first):
        columns = [_signal(run, name, label) for label, run in runs.items()]
        values = np.stack([np.interp(times, one["time"], one) for one in columns])
        attributes = {"units": columns[0].attrs["units"], "long_name": columns[0].attrs["long_name"]}
        found[name] = xr.DataArray(values, dims=("run", "time"), attrs=attributes)
        apart = np.abs(values - values[0]).max(axis=1)
        found[f"{name} largest difference"] = xr.DataArray(apart, dims="run", attrs=attributes)
    return xr.Dataset(found, {"run": list(runs), "time": ("time", times, dict(first["time"].attrs))})


def telling_signals(run: xr.Dataset) -> list[str]:
    """What is shown unless something is asked for."""
    speed = run["speed"].to_numpy()
    wheel = str(run["wheel"][0].item())
    body = next((name for name in RunInfo.of(run).moving if wheel.startswith(name)), wheel)
    changes = float(np.ptp(speed)) > STEADY * float(np.abs(speed).max())
    return [*(["speed"] if changes else []), f"lateral:{body}", f"vertical_force:{wheel}", f"lateral_force:{wheel}"]


def _signal(run: xr.Dataset, name: str, label: str) -> xr.DataArray:
    """A signal over time.

    Raises:
        ValueError: the run has none of that name.
    """
    variable, _, item = name.partition(":")
    names = [str(one) for one in run.data_vars if "time" in run[one].dims]
    if variable not in names:
        guess = nearest(variable, names)
        raise ValueError(f"{label}: no signal '{variable}'" + (f"; did you mean '{guess}'?" if guess else ""))
    values = run[variable]
    dims = [str(dim) for dim in values.dims if dim != "time"]
    if len(dims) > 1:
        raise ValueError(
            f"{label}: '{variable}' has one value for each {' and '.join(dims)}; allowed: signals of one {dims[0]}"
        )
    if not dims and not item:
        return values
    items = [str(one) for one in run[dims[0]].to_numpy()] if dims else []
    if item not in items:
        allowed = f"write {variable}:NAME with one of {', '.join(items)}" if items else f"write {variable} alone"
        raise ValueError(f"{label}: '{name}'; {allowed}")
    return values.sel({dims[0]: item})
