"""Sweeps on a dask cluster: a real scheduler and two workers on the loopback, of which one is killed."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from called import called
from rollerrig.study.checkpoint import NAME
from rollerrig.study.cluster import ClusterError, cluster

PLAN = """
name = "small"
case = "wheelset_rollers"
changes = { "time.duration" = "1 s" }
[[vary]]
key = "contact.friction.mu_0"
least = 0.1
most = 0.4
count = 40
[[measure]]
kind = "run"
"""


def free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


def sweep(folder: Path, out: str, *options: str) -> int:
    (folder / "plan.toml").write_text(PLAN)
    arguments = ["sweep", str(folder / "plan.toml"), "--out", str(folder / out), *options]
    return called(*arguments).exit_code


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:{port}", "127.0.0.1:{port}", "nonsense:address"])
def test_a_scheduler_that_is_not_there_is_one_line(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr("rollerrig.study.cluster.CONNECT_SECONDS", 0.3)
    with pytest.raises(ClusterError, match="no scheduler there") as error, cluster(address.format(port=free_port())):
        pass
    assert "\n" not in str(error.value)


def test_without_a_scheduler_nothing_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr("rollerrig.study.cluster.CONNECT_SECONDS", 0.3)
    assert sweep(tmp_path, "out", "--dask", f"tcp://127.0.0.1:{free_port()}") == 2
    assert not (tmp_path / "out").exists()


@contextmanager
def two_workers() -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """A scheduler and two workers, each a process of its own; ended as a whole."""
    address = f"tcp://127.0.0.1:{free_port()}"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "start_new_session": True}
    python = [sys.executable, "-m", "distributed.cli"]
    port = address.rpartition(":")[2]
    begun = [subprocess.Popen([f"{python[0]}", "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", port,
                               "--no-dashboard"], **quiet)]  # fmt: skip
    worker = [
        sys.executable,
        "-m",
        "distributed.cli.dask_worker",
        address,
        "--nthreads",
        "1",
        "--no-nanny",
        "--no-dashboard",
    ]
    begun += [subprocess.Popen(worker, **quiet) for _ in range(2)]
    try:
        yield address, begun[1:]
    finally:
        for process in begun:
            with_group = os.getpgid(process.pid) if process.poll() is None else None
            if with_group is not None:
                os.killpg(with_group, signal.SIGKILL)
            process.wait()


@pytest.mark.long
def test_a_worker_that_is_killed_in_the_middle_loses_nothing(tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    assert sweep(tmp_path, "alone", "--workers", "1") == 0
    with two_workers() as (address, workers):
        with distributed.Client(address, timeout=60) as client:
            client.wait_for_workers(2, timeout=60)
        journal, killed = tmp_path / "together" / NAME, threading.Event()

        def kill_one() -> None:
            while not journal.is_file() or len(journal.read_bytes().splitlines()) < 6:
                time.sleep(0.02)
            workers[0].kill()
            killed.set()

        threading.Thread(target=kill_one, daemon=True).start()
        assert sweep(tmp_path, "together", "--dask", address) == 0
        assert killed.is_set()
    for name in (NAME, "sweep.nc", "sweep.csv", "report.html"):
        assert (tmp_path / "alone" / name).read_bytes() == (tmp_path / "together" / name).read_bytes()
