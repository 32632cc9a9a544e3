"""Traction of each axle of a run over its creepage, as a locomotive's adhesion is measured.

run on track or on a rig -> [axle_traction] -> creepage and traction coefficient of each axle over time

creepage               (r w - v) / v,  v the train's speed (and the axle's own, on track), r w that of the wheels' circumference
traction coefficient   force along the rail over the vertical force that the axle carries at that instant
"""

import xarray as xr

from rollerrig.results import variable


def axle_traction(run: xr.Dataset, radius: float, *, of_virtual_axles: bool = False) -> xr.Dataset:
    """Creepage and traction coefficient of each axle.

    Args:
        run: results of `simulate`.
        radius: rolling radius of the wheels [m].
        of_virtual_axles: on a rig with [rig_control], of the axles of the virtual train on its rail, loaded as the real ones.

    Returns:
        `creepage` [-], positive in traction; `traction_coefficient` [-]; `load`, the vertical force of the axle [N], over
        (time, axle).
    """
    axles = [str(name) for name in run["axle"].to_numpy()]
    train = run["train_speed"].to_numpy()[:, None]
    load = sum(
        run["vertical_force"].sel(wheel=[f"{name}_{side}" for name in axles]).to_numpy() for side in ("left", "right")
    )
    if of_virtual_axles:
        force, sliding = run["virtual_force"].to_numpy(), radius * run["virtual_speed"].to_numpy() - train
    else:  # a bogie yields on its traction rod
        own = run["longitudinal_velocity"].sel(body=axles).to_numpy()
        force, sliding = run["creep_force"].to_numpy(), radius * run["axle_speed"].to_numpy() - train - own
    dims = ("time", "axle")
    return xr.Dataset(
        {
            "creepage": variable(
                dims, sliding / train, "1", "slip velocity over the train's speed, positive in traction"
            ),
            "traction_coefficient": variable(dims, force / load, "1", "force along the rail over the axle's load"),
            "load": variable(dims, load, "N", "vertical force of both wheels"),
        },
        coords={"time": run["time"], "axle": axles},
    )
