"""Of a test on degraded adhesion: what the rig makes of it beside the track that it is to reproduce."""

from __future__ import annotations

from functools import lru_cache

from rollerrig.analysis.slide_statistics import TestRecord
from rollerrig.config import Case, case_from_toml
from rollerrig.config.schema.plan import AdhesionMeasure
from rollerrig.study.adhesion_variants import track_case
from rollerrig.study.ensemble import recorded
from rollerrig.study.jobs import Progress

QUANTITIES = {
    "distance_track": ("m", "run by the train on track"),
    "distance_rig": ("m", "run by the virtual train of the rig"),
    "distance_error": ("1", "distance on the rig over that on track, less 1"),
    "tracking_rms": ("1", "speed of the wheels less that of the virtual ones, over the train's, RMS"),
    "mean_slip_track": ("1", "mean |wheel speed - train speed| over train speed, on track"),
    "mean_slip_rig": ("1", "the same on the rig"),
    "air_track": ("m^3", "air taken by the cylinders, at ambient pressure, on track"),
    "air_rig": ("m^3", "the same on the rig"),
}


def measure(case: Case, options: AdhesionMeasure, progress: Progress | None = None) -> dict[str, float]:
    """The test on track and on the rig; the numbers of QUANTITIES. The same track is run once per worker.

    Raises:
        ConfigError: the case is not that of a rig with [rig_control] and brake or traction.
        RuntimeError: a run left the validity of its model.
    """
    if options.longest is not None:
        case = case.with_changes({"time.duration": options.longest})
    track, rig = _on_track(track_case(case).to_toml()), recorded(case, progress)
    for place, record in (("track", track), ("rig", rig)):
        if not record.completed:
            raise RuntimeError(f"on the {place}: {record.message}")
    a, b = track.measures, rig.measures
    return {
        "distance_track": a["distance_m"],
        "distance_rig": b["distance_m"],
        "distance_error": b["distance_m"] / a["distance_m"] - 1.0,
        "tracking_rms": b["tracking_rms"],
        "mean_slip_track": a["mean_slip"],
        "mean_slip_rig": b["mean_slip"],
        "air_track": 1e-3 * a["air_litres"],
        "air_rig": 1e-3 * b["air_litres"],
    }


@lru_cache(maxsize=64)
def _on_track(text: str) -> TestRecord:
    return recorded(case_from_toml(text, allow_code=True))
