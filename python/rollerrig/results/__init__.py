"""Results of a run: a Dataset with named variables and units, its energy audit, its files.

rows of the core -> [results] -> xarray.Dataset -> run.nc, summary.json, CSV
"""

from rollerrig.results.citation import cite, sources_of
from rollerrig.results.dataset import COMPLETED, Draft, Outcome, add_energy_audit, run_dataset, run_draft, variable
from rollerrig.results.files import (
    OutputError,
    ResultsError,
    load_run,
    netcdf_bytes,
    output_file,
    output_folder,
    save_run,
    write_bytes,
    write_text,
)
from rollerrig.results.folder import Manifest, ResultFolder, check_folder, read_manifest
from rollerrig.results.other_formats import export, mat_bytes
from rollerrig.results.run_info import RunInfo
from rollerrig.results.summary import motion_table, summarise, wheel_table
from rollerrig.results.termination import add_termination

__all__ = [
    "COMPLETED",
    "Draft",
    "Manifest",
    "Outcome",
    "OutputError",
    "ResultFolder",
    "ResultsError",
    "RunInfo",
    "add_energy_audit",
    "add_termination",
    "check_folder",
    "cite",
    "export",
    "load_run",
    "mat_bytes",
    "motion_table",
    "netcdf_bytes",
    "output_file",
    "output_folder",
    "read_manifest",
    "run_dataset",
    "run_draft",
    "save_run",
    "sources_of",
    "summarise",
    "variable",
    "wheel_table",
    "write_bytes",
    "write_text",
]
