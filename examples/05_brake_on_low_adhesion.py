"""Does a dry rig reproduce a brake test on a slippery rail? Ten seconds of it, beside the same test on the degraded track."""

import rollerrig as rr

case = rr.load_case("adhesion_brake").with_changes({"time.duration": "10 s"})
found = rr.adhesion(case, error_budget=False)
print(found.summary)
found.write("brake")  # report.html, summary.json, results as NetCDF, figures
