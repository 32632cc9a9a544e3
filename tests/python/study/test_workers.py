"""Worker processes: the same results as in one process, one job lost with a process at most, Ctrl-C, no process left behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from rollerrig.simulation.run import Progress
from rollerrig.study.jobs import Chains, Done, Round, run_rounds, whole_run
from rollerrig.study.workers import Job, WorkerError, run_jobs

BOUND = 10.0
"""A worker watches its parent as soon as it is ready: within a second, unless the machine is busy [s]."""
needs_proc = pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="looks for processes in /proc")


def run(
    function: Any, arguments: Mapping[str, Any], lost: Any = None, **options: Any
) -> tuple[Done, bool, list[float]]:
    """Results, whether Ctrl-C ended the jobs, and the fractions reported."""
    done: Done = {}
    shown: list[float] = []

    def keep(name: str, result: Any) -> dict[str, Job]:
        assert threading.current_thread() is threading.main_thread()
        done[name] = result
        return {}

    jobs = {name: Job(function, (argument,), lost) for name, argument in arguments.items()}
    stopped = run_jobs(jobs, keep, lambda count, _name: shown.append(count), **options)
    return done, stopped, shown


def square(number: int, progress: Progress) -> int:
    progress(0.5, "")
    return number**2


def interrupted_at_three(number: int) -> int:
    if number == 3:
        raise KeyboardInterrupt
    return number


@pytest.mark.slow
@pytest.mark.parametrize("processes", [1, 2])
def test_each_result_is_kept_once_and_the_progress_rises(processes: int) -> None:
    done, stopped, shown = run(square, {str(k): k for k in range(6)}, processes=processes)
    assert done == {str(k): k * k for k in range(6)}
    assert not stopped
    assert shown == sorted(shown)
    assert (shown[0], shown[-1]) == (0.0, 6.0)


def test_an_interrupt_within_a_job_keeps_what_is_done() -> None:
    assert run(interrupted_at_three, {str(k): k for k in (1, 2, 3, 4)})[:2] == ({"1": 1, "2": 2}, True)


@pytest.mark.slow
def test_chains_run_side_by_side_and_a_job_brings_the_one_that_follows_it() -> None:
    def chain(start: int) -> Any:
        def following(done: Done) -> Round:
            number = start
            while f"{number}" in done:
                number = done[f"{number}"]
            return {f"{number}": Job(square, (number,))} if number < 100 else {}

        return following

    expected = {"2": 4, "4": 16, "16": 256, "3": 9, "9": 81, "81": 6561}
    for processes in (1, 2):
        found, _ = run_rounds(lambda _: iter([Chains((chain(2), chain(3)), 6)]), None, (1.0,), processes, None)
        assert list(found.items()) == list(expected.items()), "one chain after the other"


def late(number: int) -> int:
    """The lower its number the later a job ends."""
    time.sleep(0.3 / number)
    return number


@pytest.mark.slow
def test_a_chain_of_rounds_waits_for_its_own_jobs_alone() -> None:
    """Names and order of the jobs are those of one process, whichever job ends first."""

    def chain(name: str, first: int) -> Any:
        def following(done: Done) -> Round:
            for row in ([first, first + 1, first + 2], [10 * first]):
                wanted = {f"{name}{number}": Job(late, (number,)) for number in row}
                if missing := {key: one for key, one in wanted.items() if key not in done}:
                    return missing
            return {}

        return following

    orders = []
    for processes in (1, 2, 4):
        chains = Chains((chain("a", 1), chain("b", 4)), 8)
        found, _ = run_rounds(lambda _, chains=chains: iter([chains]), None, (1.0,), processes, None)  # type: ignore[misc]
        orders.append(list(found.items()))
    expected = [("a", 1), ("a", 2), ("a", 3), ("a", 10), ("b", 4), ("b", 5), ("b", 6), ("b", 40)]
    assert orders == [[(f"{name}{number}", number) for name, number in expected]] * 3


def fails(name: str) -> None:
    raise FileNotFoundError(f"no {name}")


@pytest.mark.slow
def test_an_error_of_a_job_is_its_own_and_says_where() -> None:
    """Also one of the kind that a broken pipe has."""
    with pytest.raises(FileNotFoundError, match=r"no [ab]") as error:
        run(fails, {"a": "a", "b": "b"}, processes=2)
    assert "in fails" in str(error.value.__cause__)
    with pytest.raises(TypeError, match="cannot pickle"):
        run(unpicklable, {"a": 1, "b": 2}, processes=2)


def unpicklable(_number: int) -> Any:
    return threading.Lock()


# --------------------------------------------------------------------------------------------- processes that die


def killed(job: tuple[Path, int], progress: Progress) -> int:
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


@pytest.mark.slow
def test_a_process_that_dies_costs_its_own_job_at_most(tmp_path: Path) -> None:
    jobs = {str(number): (tmp_path, number) for number in range(8)}
    done, stopped, _ = run(killed, jobs, lambda job: -job[1], processes=2)
    assert done == {**{str(number): number for number in range(7)}, "7": -7}
    assert not stopped
    with pytest.raises(WorkerError, match="in the middle of its job, 7: killed, or out of memory"):
        run(killed, {"7": (tmp_path, 7), "6": (tmp_path, 6)}, processes=2)


def killed_afterwards(number: int) -> int:
    threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGKILL)).start()
    return number


@pytest.mark.slow
def test_a_process_that_dies_between_two_jobs_costs_none() -> None:
    done: Done = {}

    def keep(name: str, result: Any) -> dict[str, Job]:
        done[name] = result
        if len(done) != 2:
            return {}
        time.sleep(1.0)
        return {name: Job(abs, (-3,)) for name in "cdef"}

    assert not run_jobs({name: Job(killed_afterwards, (3,)) for name in "ab"}, keep, lambda *_: None, processes=2)
    assert done == dict.fromkeys("abcdef", 3)


def killed_while_it_sends(seen: Path) -> bytes:
    def kill() -> None:
        while sys._current_frames()[threading.main_thread().ident or 0].f_code.co_name != "_send":
            pass
        os.kill(os.getpid(), signal.SIGKILL)

    if not seen.exists():
        seen.touch()
        threading.Thread(target=kill, daemon=True).start()
    return bytes(1 << 26)


@pytest.mark.slow
def test_half_a_result_of_a_process_that_died_is_not_waited_for(tmp_path: Path) -> None:
    script = (
        "import sys, pathlib\n"
        f"sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
        "import test_workers as t\n"
        f"jobs = {{name: pathlib.Path({str(tmp_path)!r}, name) for name in 'ab'}}\n"
        "done, stopped, _ = t.run(t.killed_while_it_sends, jobs, processes=2)\n"
        "assert not stopped and [len(one) for one in done.values()] == [1 << 26] * 2\n"
    )
    subprocess.run([sys.executable, "-c", script], check=True, timeout=60)


class KilledWorker(Exception):
    """A scheduler gives up a job that has ended several workers."""


def killed_elsewhere(number: int) -> int:
    if number == 1:
        raise KilledWorker
    return number


def test_a_job_that_ends_workers_elsewhere_is_lost_too() -> None:
    with ThreadPoolExecutor(1) as executor:
        assert run(killed_elsewhere, {"0": 0, "1": 1, "2": 2}, lambda job: -job, executor=executor)[0] == {
            "0": 0,
            "1": -1,
            "2": 2,
        }


@pytest.mark.slow
def test_several_processes_give_the_same_bits() -> None:
    from rollerrig.study.runs.paper import traction_case

    short = traction_case().with_changes({"time.duration": "0.2 s"})
    one, two = run(whole_run, {"a": short, "b": short}, processes=2)[0].values()
    assert one.identical(two)
    assert one.identical(whole_run(short))


# --------------------------------------------------------------------------------------------------------- Ctrl-C

STUBBORN = """
import os, signal, sys, threading, time
from rollerrig.cli.progress import interrupts_noted, progress_bar
from rollerrig.study.workers import Job, run_jobs

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

def keep(number, result):
    kept[number] = result
    threading.Thread(target=press, args=(int(sys.argv[1]),), daemon=True).start()
    return {}

if __name__ == "__main__":
    kept, begun = {}, time.monotonic()
    jobs = {str(number): Job(stubborn, (number,)) for number in range(4)}
    try:
        with interrupts_noted() as handler, progress_bar("stubborn", handler) as progress:
            print(run_jobs(jobs, keep, progress, processes=2))
    finally:
        print(kept, "within", time.monotonic() - begun < 40.0)
"""


@pytest.mark.parametrize(("presses", "code", "printed"), [(1, 0, "True\n"), (2, 130, "")])
def test_ctrl_c_ends_jobs_that_never_look_up(presses: int, code: int, printed: str, tmp_path: Path) -> None:
    """Once: reported at once, killed after some seconds; twice: at once. What was finished is handed over either way."""
    script = tmp_path / "stubborn.py"
    script.write_text(STUBBORN)
    command = [sys.executable, script, str(presses)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == code, done.stderr
    assert done.stdout == printed + "{'0': 0} within True\n"
    assert done.stderr.count("Interrupted, writing results") == 1
    assert "Traceback" not in done.stderr


def test_a_script_without_a_main_guard_is_one_error(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    jobs = "{name: Job(abs, (1,)) for name in 'ab'}"
    script.write_text(
        f"from rollerrig.study.workers import Job, run_jobs\nrun_jobs({jobs}, dict, print, processes=2)\n"
    )
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "WorkerError: a worker process ended before its first job: out of memory, or a script without" in done.stderr


# ------------------------------------------------------------------------------------------- no process left behind


def say_and_work(folder: Path) -> None:
    (folder / str(os.getpid())).touch()
    time.sleep(600.0)


def alive(process: int) -> bool:
    try:
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"  # one whose exit code was not read yet


def children(process: int) -> set[int]:
    return set(map(int, Path(f"/proc/{process}/task/{process}/children").read_text().split())) | {
        int(number)
        for task in Path(f"/proc/{process}/task").iterdir()
        for number in (task / "children").read_text().split()
    }


@pytest.mark.slow
@needs_proc
@pytest.mark.parametrize("begun", [True, False], ids=["at work", "while they import"])
def test_workers_end_when_the_program_is_killed(tmp_path: Path, begun: bool) -> None:
    script = f"""
import sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
from pathlib import Path
import test_workers as t
t.run(t.say_and_work, dict.fromkeys("ab", Path({str(tmp_path)!r})), processes=2)
"""
    parent = subprocess.Popen([sys.executable, "-c", script])
    try:
        end = time.monotonic() + 60.0
        while len(workers := children(parent.pid)) < 2 or (begun and len(list(tmp_path.iterdir())) < 2):
            assert time.monotonic() < end, "the workers never started"
            assert parent.poll() is None
            time.sleep(0.005)
    finally:
        parent.kill()
        parent.wait()
    try:
        end = time.monotonic() + BOUND
        while any(map(alive, workers)) and time.monotonic() < end:
            time.sleep(0.02)
        assert not any(map(alive, workers))
    finally:
        for worker in filter(alive, workers):
            os.kill(worker, signal.SIGKILL)


@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="signals cannot be blocked")
def test_workers_never_see_ctrl_c_from_their_first_line_on() -> None:
    """Also the first one: multiprocessing starts its resource tracker with it, and unblocks the signal by that."""
    script = (
        "import signal\n"
        "from rollerrig.study.workers import Job, run_jobs\n"
        "blocked = {}\n"
        "jobs = {name: Job(signal.pthread_sigmask, (signal.SIG_BLOCK, [])) for name in 'ab'}\n"
        "run_jobs(jobs, lambda name, mask: blocked.update({name: signal.SIGINT in mask}) or {}, print, processes=2)\n"
        "assert blocked == {'a': True, 'b': True}, blocked\n"
    )
    subprocess.run([sys.executable, "-c", script], check=True, timeout=60)
