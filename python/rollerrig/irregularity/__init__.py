"""Irregularities of the track: what the two rails deviate from their design position.

published spectrum and seed, measured file -> [RailIrregularity] -> the core's contacts
"""

from rollerrig.irregularity.measured import MeasuredTrack, measured_irregularity, read_measured_track
from rollerrig.irregularity.rails import COMPONENTS, RAILS, Component, IrregularityError, RailIrregularity
from rollerrig.irregularity.spectra import LEVELS, Level, generate, standard_deviation, track_spectrum

__all__ = [
    "COMPONENTS",
    "LEVELS",
    "RAILS",
    "Component",
    "IrregularityError",
    "Level",
    "MeasuredTrack",
    "RailIrregularity",
    "generate",
    "measured_irregularity",
    "read_measured_track",
    "standard_deviation",
    "track_spectrum",
]
