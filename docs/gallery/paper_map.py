"""Linear critical speed of the paper's bogie over what the paper leaves open: samples, and near the lowest of them a map."""

from pathlib import Path

import numpy as np
import pandas as pd

from rollerrig.plot.style import COLOURS, MARKERS, house_style, new_grid

data = pd.read_csv(Path(__file__).parents[2] / "tests" / "validation" / "data" / "paper_map.csv")
samples, near = (data[data["plan"] == plan] for plan in ("paper_critical_speed", "paper_critical_speed_near"))

with house_style():
    figure, ((over_gauge, close),) = new_grid(1, 2, height=3.6)
    for number, ((normal, material), rows) in enumerate(samples.groupby(["normal_contact", "material"])):
        style = {"color": COLOURS[number], "marker": MARKERS[number], "markersize": 3, "linestyle": "none"}
        over_gauge.plot(1e3 * rows["gauge"], rows["critical_speed_kmh"], label=f"{normal}, {material}", **style)
    over_gauge.axhline(100.0, color="k", linewidth=0.8)
    over_gauge.set_ylabel("linear critical speed [km/h]")
    over_gauge.set_ylim(0.0, 400.0)
    over_gauge.legend(fontsize=7)
    paper = near[near["creep_law"] == "kalker_saturated"]
    for number, (radius, rows) in enumerate(paper.groupby(np.round(paper["roller_radius"], 3))):
        for material, line in (("steel", "-"), ("paper", "--")):
            own = rows[rows["material"] == material].sort_values("gauge")
            label = f"{radius:.2f} m" if material == "steel" else None
            close.plot(1e3 * own["gauge"], own["critical_speed_kmh"], line, color=COLOURS[number], label=label)
    close.axhline(100.0, color="k", linewidth=0.8)
    close.set_ylim(0.0, 400.0)
    close.legend(fontsize=7, title="radius; dashed: material of the paper", title_fontsize=7)
    for axes in (over_gauge, close):
        axes.set_xlabel("gauge [mm]")
