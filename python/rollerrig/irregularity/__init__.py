"""Irregularities of the track: what the two rails deviate from their design position.

published spectrum and seed, measured file -> [RailIrregularity] -> the core's contacts
"""

from rollerrig.irregularity.measured import measured_irregularity as measured_irregularity
from rollerrig.irregularity.measured import read_measured_track as read_measured_track
from rollerrig.irregularity.rails import COMPONENTS as COMPONENTS
from rollerrig.irregularity.rails import RAILS as RAILS
from rollerrig.irregularity.rails import IrregularityError as IrregularityError
from rollerrig.irregularity.rails import RailIrregularity as RailIrregularity
from rollerrig.irregularity.spectra import generate as generate
from rollerrig.irregularity.spectra import track_spectrum as track_spectrum
