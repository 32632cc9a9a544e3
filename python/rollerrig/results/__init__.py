"""Results of a run: a Dataset with named variables and units, its energy audit, its files.

rows of the core -> [results] -> xarray.Dataset -> run.nc, summary.json, CSV
"""

from rollerrig.results.dataset import COMPLETED as COMPLETED
from rollerrig.results.dataset import Draft as Draft
from rollerrig.results.dataset import Outcome as Outcome
from rollerrig.results.dataset import add_energy_audit as add_energy_audit
from rollerrig.results.dataset import run_dataset as run_dataset
from rollerrig.results.dataset import run_draft as run_draft
from rollerrig.results.dataset import variable as variable
from rollerrig.results.files import OutputError as OutputError
from rollerrig.results.files import load_run as load_run
from rollerrig.results.files import netcdf_bytes as netcdf_bytes
from rollerrig.results.files import output_file as output_file
from rollerrig.results.files import output_folder as output_folder
from rollerrig.results.files import save_run as save_run
from rollerrig.results.files import write_bytes as write_bytes
from rollerrig.results.files import write_text as write_text
from rollerrig.results.folder import ResultFolder as ResultFolder
from rollerrig.results.folder import check_folder as check_folder
from rollerrig.results.folder import locked as locked
from rollerrig.results.folder import read_manifest as read_manifest
from rollerrig.results.other_formats import export as export
from rollerrig.results.other_formats import mat_bytes as mat_bytes
from rollerrig.results.run_info import ResultsError as ResultsError
from rollerrig.results.run_info import RunInfo as RunInfo
from rollerrig.results.run_info import cite as cite
from rollerrig.results.run_info import sources_of as sources_of
from rollerrig.results.summary import summarise as summarise
from rollerrig.results.termination import add_termination as add_termination
