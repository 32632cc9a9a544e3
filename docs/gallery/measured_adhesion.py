"""Traction coefficient of a locomotive: measured means, and every creep law with published and with fitted parameters."""

import csv
import tomllib
from pathlib import Path

import numpy as np

import rollerrig as rr
from rollerrig import _core
from rollerrig.assembly.laws import creep_law
from rollerrig.contact_analysis.traction_curve import LoadedWheel, traction_coefficient
from rollerrig.plot.style import COLOURS, MARKERS, house_style, new_grid

data = Path(__file__).parents[2] / "tests" / "validation" / "data"
with (data / "eurosprinter_bins.csv").open() as lines:
    means = {key: np.array(column, dtype=float) for key, *column in zip(*csv.reader(lines), strict=True)}
wheel = LoadedWheel(radius=0.625, load=106.7e3, speed=10.0, a_over_b=0.5, shear_modulus=82e9, poisson_ratio=0.28)
creepage = np.geomspace(0.003, 0.25, 150)


def curve(law: str, numbers: dict[str, float]) -> np.ndarray:
    friction = _core.friction_laws["falling"](**{name: numbers[name] for name in ("mu_0", "A", "B")})
    own = {name: numbers[name] for name in ("k_0", "k_inf", "beta") if name in numbers}
    own |= {name: numbers[name] for name in ("k_A", "k_S") if law == "polach"}
    reduction = (numbers["k_A"], numbers["k_S"]) if "k_A" in numbers else None
    return traction_coefficient(wheel, creepage, friction, creep_law(law, **own), reduction)


laws = ("polach", "modified_fastsim", "table", "fastsim", "kalker_saturated")
with house_style():
    figure, ((published, fitted),) = new_grid(1, 2, height=3.8, sharex=True)
    for one in tomllib.loads((data / "eurosprinter_sets.toml").read_text("utf-8"))["set"]:
        number = laws.index(one["law"])
        axes, style = (fitted, "-") if one["fitted"] else (published, "--")
        name = one["law"].replace("_", " ") + (
            "" if one["fitted"] or "condition" not in one else f", {one['condition']}"
        )
        marks = {
            "marker": MARKERS[number],
            "markersize": 3.5,
            "markerfacecolor": "w",
            "markevery": (5 + 5 * number, 30),
        }
        axes.plot(100 * creepage, curve(one["law"], one["numbers"]), style, color=COLOURS[number], label=name, **marks)
    case = rr.load_case("eurosprinter_traction")
    run = rr.simulate(case)
    axle = run.sel(axle="wheelset_1", body="wheelset_1", wheel=["wheelset_1_left", "wheelset_1_right"])
    train = run["train_speed"] + axle["longitudinal_velocity"]  # the bogie yields on its traction rod
    slip = ((case.vehicle.data.wheel.radius * axle["axle_speed"] - train) / run["train_speed"]).to_numpy()
    traction = axle["creep_force"] / axle["vertical_force"].sum("wheel")
    shown = (slip > 0.003) & (slip < 0.25)
    fitted.plot(100 * slip[shown], traction[shown], "k:", linewidth=2.0, label="bogie, leading axle")
    for axes, title in ((published, "published parameters"), (fitted, "fitted to the means")):
        bars = {"fmt": "o", "color": "k", "markersize": 3.5, "linewidth": 0.9, "capsize": 2}
        label = "measured, ±3 standard errors"
        axes.errorbar(means["creepage_mean"], means["traction_mean"], 3 * means["traction_se"], label=label, **bars)
        axes.set_xscale("log")
        axes.set_xticks([0.3, 1, 3, 10, 25], ["0.3", "1", "3", "10", "25"])
        axes.minorticks_off()
        axes.set_xlabel("creepage [%]")
        axes.set_title(title, loc="left")
        axes.legend(fontsize=7, loc="lower center")
    published.set_ylabel("traction coefficient [-]")
    published.set_ylim(0.0, 0.5)
    published.text(3.0, 0.46, "dry", ha="center")
    published.text(8.0, 0.225, "wet", ha="center")
    fitted.set_ylim(0.12, 0.34)
