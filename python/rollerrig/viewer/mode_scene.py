"""Mode shapes as a page shows them: the vehicle of the case, and of every mode at every speed how its bodies move.

    modes -> [mode_scene] -> Scene -> page

The page draws u(t) = amplitude cos(2 pi f t + phase) of each coordinate; the size of a mode is arbitrary, growth and decay are
left out.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from rollerrig.assembly.model import assemble
from rollerrig.config import ConfigError, case_from_toml
from rollerrig.results import ResultsError
from rollerrig.viewer import parts
from rollerrig.viewer.columns import Columns
from rollerrig.viewer.scene import MOTION, Scene

_SMALL = 1e-4
"""Share of the largest displacement or angle of a mode: less is not seen."""


def holds_modes(results: xr.Dataset) -> bool:
    """Whether results are modes, as `stability` finds them."""
    return "shape_amplitude" in results and "shape_phase" in results


def mode_scene(modes: xr.Dataset, *, label: str = "") -> Scene:
    """The scene of modes over speed.

    Args:
        modes: Dataset of `stability`.
        label: how it is called; by default its case.

    Raises:
        ResultsError: their case cannot be read by this version.
    """
    try:
        model = assemble(case_from_toml(str(modes.attrs["config_toml"]), "the case of the modes", allow_code=True))
    except (ConfigError, KeyError, ValueError, OSError) as error:
        raise ResultsError(f"the case of these modes cannot be read: {str(error).splitlines()[0]}") from None
    elements = [
        {**one, "direction": "z" if "z" in one["directions"] else one["directions"][0], "rest": 0.0, "largest": 0.0}
        for one in parts.elements(model)
    ]
    speeds = [float(v) for v in modes["speed"].to_numpy()]
    critical = float(modes.attrs.get("linear_critical_speed_kmh", np.nan))
    head: dict[str, Any] = {
        "label": label or str(modes.attrs["case"]),
        "case": str(modes.attrs["case"]),
        "title": str(modes.attrs["title"]),
        "status": "",
        "support": model.case.support.data.kind,
        "gravity": model.case.gravity,
        "bodies": parts.bodies(model),
        "wheels": parts.wheels(model),
        "elements": elements,
        "shapes": parts.shapes(model),
        "line": parts.track(model, 0.0, 0.0),
        "patches": 0,
        "brakes": False,
        "motors": False,
        "axles": list(model.wheelsets),
        "frames": 0,
        "samples": 0,
        "errors": {},
        "columns": {},
        "plots": [],
        "speeds": speeds,
        "speed": int(np.argmin(np.abs(np.array(speeds) - critical))) if np.isfinite(critical) else len(speeds) - 1,
        "mode": _first(modes),
        "modes": [_mode(modes.sel(mode=name), model.bodies) for name in modes["mode"].to_numpy().tolist()],
    }
    return Scene(head, Columns())


def _first(modes: xr.Dataset) -> int:
    """Number of the mode that is shown first: the one that becomes unstable first, else a hunting mode."""
    names = modes["mode"].to_numpy().tolist()
    chosen = modes.attrs.get("linear_critical_mode") or modes.attrs.get("hunting_mode")
    return names.index(chosen) if chosen in names else 0


def _mode(mode: xr.Dataset, bodies: tuple[str, ...]) -> dict[str, Any]:
    """Frequency, damping and shape at each speed: coordinate -> amplitude and phase, as in a run's columns."""
    amplitude, phase = mode["shape_amplitude"].to_numpy(), np.radians(mode["shape_phase"].to_numpy())
    names = [str(name) for name in mode["body"].to_numpy()]
    shapes = []
    for speed in range(amplitude.shape[0]):
        largest = float(np.nanmax(amplitude[speed], initial=0.0)) or 1.0
        shapes.append(
            {
                f"b{bodies.index(body)}.{MOTION[k]}": [
                    round(float(amplitude[speed, b, k]) / largest, 5),
                    round(float(phase[speed, b, k]), 4),
                ]
                for b, body in enumerate(names)
                for k in range(len(MOTION))
                if amplitude[speed, b, k] > _SMALL * largest
            }
        )
    finite = {key: [_number(v) for v in mode[key].to_numpy()] for key in ("frequency", "damping")}
    return {"name": str(mode["mode"].item()), **finite, "shapes": shapes}


def _number(value: float) -> float | None:
    return round(float(value), 6) if np.isfinite(value) else None
