"""What does another program find in a run that is exported?"""

import scipy.io

import rollerrig as rr

run = rr.simulate(rr.load_case("wheelset_rollers").with_changes({"time.duration": "0.5 s"}))
for name in ("run.mat", "run.csv", "run.parquet"):
    print(rr.export(run, name))

found = scipy.io.loadmat("run.mat")
print(
    f"vertical_force: {found['dimensions']['vertical_force'].item().item()}, {found['units']['vertical_force'].item().item()}"
)
print(f"the same numbers: {bool((found['vertical_force'] == run['vertical_force'].to_numpy()).all())}")
