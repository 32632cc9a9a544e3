"""In a tool that is not ours: libcosim, which reads FMUs by FMI Library and steps all of them side by side."""

from __future__ import annotations

import re
from pathlib import Path

import fmpy
import pytest

from rollerrig import export_fmu, export_part, load_case, simulate

libcosim = pytest.importorskip("libcosimpy.CosimExecution", reason="libcosimpy is there on Linux only")
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level  # noqa: E402
from libcosimpy.CosimObserver import CosimObserver  # noqa: E402
from libcosimpy.CosimSlave import CosimLocalSlave  # noqa: E402

STEP = 1e-3  # of the communication [s]
QUANTITIES = ("train.speed", "wheelset_1.cylinder_pressure", "wheelset_2_left.vertical_force")


class Tool:
    """One simulation in libcosim, with a step of 1 ms."""

    def __init__(self, **files: Path) -> None:
        log_output_level(CosimLogLevel.WARNING)
        self.execution = libcosim.CosimExecution.from_step_size(STEP * 1e9)  # ns
        self.index = {
            name: self.execution.add_local_slave(CosimLocalSlave(str(file), name)) for name, file in files.items()
        }
        self.references = {
            name: {variable.name.decode(): variable.reference for variable in self.execution.slave_variables(index)}
            for name, index in self.index.items()
        }
        self.observer = CosimObserver.create_last_value()
        self.execution.add_observer(self.observer)

    def connect(self, source: tuple[str, str], target: tuple[str, str]) -> None:
        ends = [x for unit, name in (source, target) for x in (self.index[unit], self.references[unit][name])]
        assert self.execution.connect_real_variables(*ends) == 0

    def run(self, steps: int, unit: str) -> list[float]:
        """QUANTITIES after so many steps."""
        assert self.execution.step(steps)
        references = [self.references[unit][name] for name in QUANTITIES]
        return list(self.observer.last_real_values(self.index[unit], references))


def test_the_run_is_that_of_fmpy_and_the_description_is_without_fault(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    bench = export_fmu("adhesion_brake", tmp_path / "bench.fmu", kind="both")
    bogie = export_fmu("bogie_rollers_constant", tmp_path / "bogie.fmu", kind="both")
    part = export_part("adhesion_brake", "rig_control", tmp_path / "part.fmu")
    found = Tool(bench=bench, bogie=bogie, part=part).run(700, "bench")
    expected = fmpy.simulate_fmu(
        str(bench), fmi_type="CoSimulation", stop_time=0.7, step_size=STEP, output_interval=STEP, output=QUANTITIES
    )
    assert found == [expected[name][-1] for name in QUANTITIES]
    assert expected["wheelset_1.cylinder_pressure"][-1] > 0.0
    said = capfd.readouterr()
    assert re.findall(r"\[(?:warning|error)\].*", said.out + said.err) == []


@pytest.mark.slow
def test_bench_and_slide_protection_side_by_side_are_the_built_in_loop(tmp_path: Path) -> None:
    """A command reaches the bench one communication step after its sample: the delay of the built-in controller."""
    case = load_case("adhesion_brake").with_changes({"time.duration": "4 s"})
    assert case.slide_protection.delay == STEP
    no_delay = case.with_changes({"slide_protection.delay": "0 s"})
    tool = Tool(
        bench=export_fmu(no_delay, tmp_path / "bench.fmu", external=["slide_protection"]),
        protection=export_part(case, "slide_protection", tmp_path / "protection.fmu"),
    )
    for axle in ("wheelset_1", "wheelset_2"):
        tool.connect(("bench", f"slide_protection.{axle}.axle_speed"), ("protection", f"{axle}.axle_speed"))
        tool.connect(("protection", f"{axle}.valve_command"), ("bench", f"{axle}.valve_command"))
    run = simulate(case)
    end = run.isel(time=-1)
    assert tool.run(4000, "bench") == [
        float(end["train_speed"]),
        float(end["cylinder_pressure"].sel(axle="wheelset_1")),
        float(end["vertical_force"].sel(wheel="wheelset_2_left")),
    ]
    assert (run["valve"] == 2.0).any()
