"""Jobs in one process and in several give the same; Ctrl-C keeps what is done."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
import typer

from rollerrig.analysis.crew import Progress
from rollerrig.analysis.parallel import run_jobs
from rollerrig.cli.termination import BAD_INPUT, readable_errors


def square(number: int, progress: Progress) -> int:
    progress(1.0, "")
    return number**2


def interrupted_at_three(number: int, progress: Progress) -> int:
    if number == 3:
        raise KeyboardInterrupt
    return number


def test_results_come_in_the_order_of_the_arguments() -> None:
    seen: list[float] = []
    done = run_jobs(square, [1, 2, 3, 4], progress=lambda fraction, _: seen.append(fraction))
    assert done.results == [1, 4, 9, 16]
    assert seen == sorted(seen)
    assert seen[-1] == 1.0


def test_ctrl_c_keeps_what_is_done() -> None:
    done = run_jobs(interrupted_at_three, [1, 2, 3, 4])
    assert done.interrupted
    assert done.results == [1, 2, None, None]


def dies_at_one(number: int, progress: Progress) -> int:
    if number == 1:
        os._exit(1)
    return square(number, progress)


def test_a_worker_that_dies_is_said_in_a_line(capfd: pytest.CaptureFixture[str]) -> None:
    """Only after all the other jobs that its end took along are done."""
    kept: dict[int, int] = {}
    with pytest.raises(typer.Exit) as end:
        readable_errors(run_jobs)(dies_at_one, range(3), processes=2, names=["a", "b", "c"], keep=kept.__setitem__)
    assert end.value.exit_code == BAD_INPUT
    assert capfd.readouterr().err.startswith("rollerrig: a worker process ended in the middle of its job, b: ")


def killed_the_first_time(job: tuple[Path, int], progress: Progress) -> int:
    """One that is killed as the kernel does it, the first time only; one that always crashes."""
    folder, number = job
    progress(0.5, "")
    seen = folder / str(number)
    if number == 0 and not seen.exists():
        seen.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    if number == 7:
        os.kill(os.getpid(), signal.SIGSEGV)
    return number


def test_the_job_of_a_worker_that_was_killed_is_done_again_and_one_that_kills_each_is_named(tmp_path: Path) -> None:
    arguments = [(tmp_path, number) for number in range(8)]
    done = run_jobs(killed_the_first_time, arguments, processes=2, lost=lambda job: -job[1])
    assert done.results == [0, 1, 2, 3, 4, 5, 6, -7]
    assert not done.interrupted


class KilledWorker(Exception):
    """A scheduler gives up a job that has ended several workers."""


def killed_elsewhere(number: int, _progress: Progress) -> int:
    if number == 1:
        raise KilledWorker
    return number


def test_a_job_that_ends_workers_elsewhere_is_named_too() -> None:
    with ThreadPoolExecutor(1) as executor:
        done = run_jobs(killed_elsewhere, [0, 1, 2, 1], executor=executor, lost=lambda job: -job)
    assert done.results == [0, -1, 2, -1]


def test_a_job_brings_the_one_that_follows_it() -> None:
    kept: dict[int, int] = {}

    def following(number: int) -> tuple[str, int] | None:
        return ("next", kept[number]) if kept[number] < 100 else None

    for processes in (1, 2):
        kept.clear()
        done = run_jobs(square, [2, 3], processes=processes, keep=kept.__setitem__, following=following)
        assert done.results[:2] == [4, 9]
        assert sorted(done.results) == [4, 9, 16, 81, 256, 6561]


def test_several_processes_give_the_same() -> None:
    # a function of the package: a fresh process cannot import this test module by name
    from rollerrig.analysis.signals import half_waves  # noqa: F401 - the import that each process pays for
    from rollerrig.study.jobs import call, job, whole_run
    from rollerrig.study.runs.paper import QUICK, traction_case

    short = traction_case(QUICK).with_changes({"time.duration": "0.2 s"})
    jobs = [job(whole_run, short)] * 2
    one, two = run_jobs(call, jobs[:1]), run_jobs(call, jobs, processes=2)
    assert all(result is not None and result.identical(one.results[0]) for result in two.results)


def test_each_result_is_handed_over_as_soon_as_it_is_there() -> None:
    kept: dict[int, int] = {}
    run_jobs(interrupted_at_three, [1, 2, 3, 4], keep=kept.__setitem__)
    assert kept == {0: 1, 1: 2}


STUBBORN = """
import os, signal, sys, threading, time
from rollerrig.analysis import parallel

def stubborn(number, progress):
    progress(0.0, "")
    if number:
        open("begun", "w").close()
        time.sleep(60.0)  # never looks up
    return number

def press(times):
    while not os.path.exists("begun"):
        time.sleep(0.1)
    for _ in range(times):
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.7)

def main(times):
    from rollerrig.cli.progress import progress_bar
    kept = {}
    def keep(number, result):
        if number not in kept:  # one that Ctrl-C brings here again
            kept[number] = result
            threading.Thread(target=press, args=(times,), daemon=True).start()
    with progress_bar("stubborn") as progress:
        begun = time.monotonic()
        try:
            done = parallel.run_jobs(stubborn, [0, 1, 2, 3], processes=2, keep=keep, progress=progress)
            print(done.interrupted, done.results)
        finally:
            print(kept, "within", time.monotonic() - begun < 30.0)

if __name__ == "__main__":
    main(int(sys.argv[1]))
"""


@pytest.mark.parametrize(
    ("presses", "code", "printed"),
    [(1, 0, "True [0, None, None, None]\n{0: 0} within True\n"), (2, 130, "{0: 0} within True\n")],
)
def test_ctrl_c_ends_jobs_that_never_look_up(presses: int, code: int, printed: str, tmp_path: Path) -> None:
    """Once: told at once, then a few seconds of patience; twice: at once. What was finished is handed over either way."""
    script = tmp_path / "stubborn.py"
    script.write_text(STUBBORN)
    done = subprocess.run(
        [sys.executable, script, str(presses)], cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == code, done.stderr
    assert done.stdout == printed
    assert done.stderr.count("Interrupted, writing results") == 1
    assert "Traceback" not in done.stderr
