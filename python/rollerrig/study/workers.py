"""Independent jobs, several at a time, each in a worker process: progress, Ctrl-C, and processes that die.

    jobs by name -> [run_jobs] -> each result as soon as it is there

One job at a time runs in this process. Several run in worker processes: a third to two thirds of a short run, and all of a
linearisation, are Python, where threads wait for each other; code of a user may hold the interpreter or keep a state of its
own; and a process that dies costs one job. A thread per worker hands over the jobs, so that it is known which job a process
died of.

Libraries in place of this file: `ProcessPoolExecutor` and loky lose all running jobs with one process, and do not say which of
them was the cause; pebble does, but has no progress, leaves its workers where the program is killed, and is under the LGPL;
a `LocalCluster` of dask takes seconds to start. A cluster that is there already is used (cluster.py).
"""

from __future__ import annotations

import ctypes
import inspect
import math
import multiprocessing
import os
import pickle
import signal
import sys
import threading
import time
import traceback
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import CancelledError, Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from queue import Empty, SimpleQueue
from types import FrameType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # a worker watches its parent before it imports what its jobs need
    from rollerrig.simulation.run import Progress

AHEAD, ELSEWHERE_AHEAD = 4, 256
"""Jobs per worker that are handed out before one is done; the same of an executor whose workers are not counted here."""

GRACE_SECONDS = 3.0
"""After Ctrl-C a job has so long to return what it has; then its process is killed."""

POLL_SECONDS = 0.1
"""Between two looks at the progress of the jobs, and at whether they shall stop."""

_CONTEXT = multiprocessing.get_context("spawn")
_STOP = b"stop"
_PR_SET_PDEATHSIG = 1  # <linux/prctl.h>


class WorkerError(RuntimeError):
    """A worker process did not start, or ended in the middle of a job, also where the job was done once more."""

    def __init__(self, job: str = "") -> None:
        super().__init__(
            f"a worker process ended in the middle of its job, {job}: killed, or out of memory; "
            "the same command continues with what is finished, best on fewer processes"
            if job
            else "a worker process ended before its first job: out of memory, or a script without "
            "`if __name__ == '__main__':` around what it runs"
        )


class _WorkerDiedError(Exception):
    """The process of a job ended."""


@dataclass(frozen=True)
class Job:
    """A call to be made on any process.

    Attributes:
        function: on the top level of a module; it gets `progress` if it has such a parameter.
        arguments: all its other arguments.
        lost: called with `arguments` for the result where the job ends its process again and again; None: that is an error.
    """

    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    lost: Callable[..., Any] | None = None

    def call(self, progress: Progress) -> Any:
        """Do it."""
        takes_progress = "progress" in inspect.signature(self.function).parameters
        return self.function(*self.arguments, **({"progress": progress} if takes_progress else {}))


def run_jobs(
    jobs: Mapping[str, Job],
    keep: Callable[[str, Any], Mapping[str, Job]],
    report: Progress,
    *,
    processes: int = 1,
    executor: Executor | None = None,
) -> bool:
    """Run jobs. One whose process died is run once more, alone, when all others are done.

    Args:
        jobs: by name.
        keep: called in this thread with name and result of each job as soon as it is done; returns jobs that follow it.
        report: called now and then with how many jobs' worth of work is done, and the name of the last finished job.
        processes: how many at a time; 1 stays in this process. More start fresh Python processes: a script that asks for
            them needs `if __name__ == "__main__":`.
        executor: runs the jobs in place of processes of this machine; it stays open.

    Returns:
        Whether Ctrl-C, or a KeyboardInterrupt of `report` or of a job, ended them early.

    Raises:
        WorkerError: no worker process starts, or a job without `lost` ended two of them; what was finished has been kept.
    """
    run = _Run(jobs, keep, report, min(processes, len(jobs)), executor)
    with _interrupt_calls(run.stop):
        return run.all_jobs()


class _Run:
    """The jobs of one call: those that wait, those that are running, and what runs them.

    Worker processes each have a thread of this process that gives them one job after the other.
    """

    def __init__(
        self,
        jobs: Mapping[str, Job],
        keep: Callable[[str, Any], Mapping[str, Job]],
        report: Progress,
        count: int,
        executor: Executor | None,
    ):
        self._keep, self._report, self._elsewhere = keep, report, executor
        self._threads = None if executor or count < 2 else ThreadPoolExecutor(count, initializer=_block_interrupts)
        self._room = ELSEWHERE_AHEAD if executor else AHEAD * count if self._threads else 1
        self._own = threading.local()  # pipe and process of each thread
        self._processes = list[BaseProcess]()  # all of them
        self._waiting, self._alone, self._died = deque(jobs.items()), deque[tuple[str, Job]](), set[str]()
        self._running: dict[Future[Any], tuple[str, Job]] = {}
        self._finished: SimpleQueue[Future[Any]] = SimpleQueue()
        self._stopped = threading.Event()
        self._fractions: dict[int, float] = {}  # thread -> how far its job is
        self._count, self._last, self._shown = 0, next(iter(jobs), ""), 0.0

    def all_jobs(self) -> bool:
        """Run them all; whether they were stopped. No process is left behind."""
        try:
            self._look()
            while self._hand_out():
                self._take_next()
                self._look()
            return self._stopped.is_set()
        finally:
            self._stopped.set()
            for process in list(self._processes):
                process.kill()
            if self._threads:
                self._threads.shutdown()
            for process in self._processes:
                process.join()

    def stop(self) -> None:
        """Ask the jobs to end."""
        self._stopped.set()
        for future in list(self._running):
            future.cancel()

    def _hand_out(self) -> bool:
        """Submit jobs as long as there is room; whether any are running."""
        while not self._stopped.is_set():
            if self._waiting and len(self._running) < self._room:
                name, job = self._waiting.popleft()
            elif self._alone and not self._running:
                name, job = self._alone.popleft()
            else:
                break
            future = self._submit(job)
            self._running[future] = name, job
            future.add_done_callback(self._finished.put)
        return bool(self._running)

    def _submit(self, job: Job) -> Future[Any]:
        if self._elsewhere:
            return self._elsewhere.submit(_call, job)
        if self._threads:
            return self._threads.submit(self._in_worker, job)
        future: Future[Any] = Future()

        def progress(fraction: float, _text: str) -> None:
            self._fractions[0] = fraction
            self._look()
            if self._stopped.is_set():
                raise KeyboardInterrupt

        try:
            future.set_result(job.call(progress))
        except (Exception, KeyboardInterrupt) as error:
            future.set_exception(error)
        self._fractions.clear()
        return future

    def _take_next(self) -> None:
        """Wait a moment for the next job that is done, and keep its result."""
        try:
            future = self._finished.get(timeout=POLL_SECONDS)
        except Empty:
            return
        name, job = self._running.pop(future)
        try:
            result = future.result()
        except (KeyboardInterrupt, CancelledError):
            self.stop()
            return
        except Exception as error:
            if isinstance(error, _WorkerDiedError) and name not in self._died:
                self._died.add(name)
                self._alone.append((name, job))
                return
            # KilledWorker: of dask, which need not be installed; its scheduler has tried the job on several workers
            if type(error).__name__ not in (_WorkerDiedError.__name__, "KilledWorker"):
                raise
            if job.lost is None:
                raise WorkerError(name) from None
            result = job.lost(*job.arguments)
        self._waiting.extend(self._keep(name, result).items())
        self._count, self._last = self._count + 1, name

    def _look(self) -> None:
        """Report what is done, never less than before."""
        if not self._stopped.is_set():
            self._shown = max(self._shown, self._count + sum(list(self._fractions.values())))
            try:
                self._report(self._shown, self._last)
            except KeyboardInterrupt:
                self.stop()

    def _in_worker(self, job: Job) -> Any:
        """Let the process of this thread do a job.

        Raises:
            KeyboardInterrupt: the jobs were stopped.
            WorkerError: the process ended before it was ready.
            _WorkerDiedError: it ended in the middle of the job.
        """
        content, deadline = pickle.dumps(Job(job.function, job.arguments)), math.inf
        try:
            if self._stopped.is_set():
                raise EOFError
            if not hasattr(self._own, "pipe"):
                self._begin_worker()
            pipe: Connection = self._own.pipe
            pipe.send_bytes(content)
            while True:
                if self._stopped.is_set() and deadline == math.inf:
                    deadline = time.monotonic() + GRACE_SECONDS
                    pipe.send_bytes(_STOP)
                if time.monotonic() > deadline:
                    self._own.process.kill()
                if pipe.poll(POLL_SECONDS):
                    kind, value = pickle.loads(pipe.recv_bytes())
                    if kind != "progress":
                        break
                    self._fractions[threading.get_ident()] = value
        except (EOFError, OSError):
            ready = self._own.__dict__.pop("pipe", None) is not None
            raise KeyboardInterrupt if self._stopped.is_set() else _WorkerDiedError if ready else WorkerError from None
        finally:
            self._fractions.pop(threading.get_ident(), None)
        if kind == "error":
            raise value
        return value

    def _begin_worker(self) -> None:
        """Start the process of this thread, and wait until it is ready."""
        pipe, other = _CONTEXT.Pipe()
        self._own.process = _CONTEXT.Process(target=_serve, args=(other,))
        self._own.process.start()
        self._processes.append(self._own.process)
        other.close()
        while not pipe.poll(POLL_SECONDS):
            if self._stopped.is_set():
                self._own.process.kill()
        pipe.recv_bytes()
        self._own.pipe = pipe


@contextmanager
def _interrupt_calls(stop: Callable[[], None]) -> Iterator[None]:
    """Within it the first Ctrl-C calls a function and raises nothing, so that no result is lost between two lines."""
    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(before):
        yield
        return
    pressed = 0

    def handle(number: int, frame: FrameType | None) -> None:
        nonlocal pressed
        pressed += 1
        stop()
        try:
            before(number, frame)
        except KeyboardInterrupt:
            if pressed > 1:
                raise

    signal.signal(signal.SIGINT, handle)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _block_interrupts() -> None:
    """Ctrl-C in a terminal reaches every process; those that this thread starts leave it to this process."""
    if hasattr(signal, "pthread_sigmask"):
        resource_tracker.ensure_running()  # started with the first process otherwise, and unblocks the signal then
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})


# ----------------------------------------------------------------------------------------- on another process


def _call(job: Job, progress: Progress = lambda _fraction, _text: None) -> Any:
    from rollerrig.common.linear_algebra import one_blas_thread

    with one_blas_thread():  # there are as many workers as cores
        return job.call(progress)


def _serve(pipe: Connection) -> None:
    """Do the jobs that come through a pipe until its other end is closed: then the parent process has ended."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # where it could not be blocked
    if sys.platform == "linux":  # also in the middle of a call into the core that holds the interpreter
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
    jobs: SimpleQueue[bytes] = SimpleQueue()
    stop = threading.Event()

    def listen() -> None:
        try:
            while True:
                message = pipe.recv_bytes()
                stop.set() if message == _STOP else jobs.put(message)
        except (EOFError, OSError):
            os._exit(1)  # no cleanup: there is nobody to report it to

    threading.Thread(target=listen, daemon=True).start()
    pipe.send_bytes(b"ready")
    while True:
        pipe.send_bytes(_answer(jobs.get(), pipe, stop))


def _answer(content: bytes, pipe: Connection, stop: threading.Event) -> bytes:
    """The result of a job, or its error."""
    sent = -math.inf

    def progress(fraction: float, _text: str) -> None:
        nonlocal sent
        if stop.is_set():
            raise KeyboardInterrupt
        if time.monotonic() > sent + POLL_SECONDS:
            sent = time.monotonic()
            pipe.send_bytes(pickle.dumps(("progress", fraction)))

    try:
        progress(0.0, "")
        return pickle.dumps(("result", _call(pickle.loads(content), progress)))
    except BaseException as error:
        error.add_note(f"in a worker process:\n{traceback.format_exc()}")
        try:
            return pickle.dumps(("error", error))
        except Exception:
            return pickle.dumps(("error", RuntimeError(f"{type(error).__name__}: {error}")))
