"""Small matrices are solved on one BLAS thread, whatever the user's setting, which is back afterwards."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import pytest
import scipy.optimize
from threadpoolctl import threadpool_info, threadpool_limits

import rollerrig
from rollerrig.analysis import loop_stability, modes
from rollerrig.analysis.control_loop import Wheel
from rollerrig.analysis.mode_table import stability
from rollerrig.analysis.signals import fit
from rollerrig.common import linear_algebra
from rollerrig.common.linear_algebra import one_blas_thread
from rollerrig.config import load_case
from rollerrig.simulation.run import simulate
from rollerrig.study.jobs import Job, run_rounds


def threads() -> set[int]:
    """Threads of each BLAS library loaded."""
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


@pytest.fixture
def two_threads():
    """A user who lets BLAS use two threads, also on one core and where the environment says one."""
    with threadpool_limits(2, user_api="blas"):
        assert threads() == {2}
        yield
        assert threads() == {2}


@pytest.fixture
def seen(monkeypatch):
    """Name of each solver that was called -> threads it was called with."""
    found: dict[str, set[int]] = {}
    linear_algebra._of_bytes.cache_clear()  # of a test before

    def watch(module: object, name: str) -> None:
        solver = getattr(module, name)

        def watched(*arguments, **options):
            found.setdefault(name, set()).update(threads())
            return solver(*arguments, **options)

        monkeypatch.setattr(module, name, watched)

    for module, names in (
        (np.linalg, ("eig", "eigvals", "lstsq")),
        (modes, ("eig",)),
        (scipy.optimize, ("linear_sum_assignment",)),  # it stands between the products of eigenvectors
        (loop_stability, ("expm",)),
    ):
        for name in names:
            watch(module, name)
    return found


def test_modes_over_speed_are_computed_on_one_thread(two_threads, seen) -> None:
    stability(load_case("wheelset_rollers"), [100.0, 120.0])
    assert seen == {"eig": {1}, "linear_sum_assignment": {1}}
    assert threads() == {2}


def test_the_checks_before_a_run_are_done_on_one_thread(two_threads, seen) -> None:
    simulate(load_case("wheelset_rollers").with_changes({"time.duration": 0.01}))
    assert seen["eigvals"] == {1}
    with pytest.raises(rollerrig.config.ConfigError):
        simulate(load_case("bogie_rollers_constant").with_changes({"vehicle.cut": "vehicle"}))
    assert seen["eig"] == {1}


def test_the_sampled_loop_and_fits_are_solved_on_one_thread(two_threads, seen) -> None:
    fit(np.arange(3.0), np.ones(3))
    made = {"step": 1e-3, "sample": 1e-3, "delay": 0.0, "drive_bandwidth": 300.0, "drive_damping": 0.0, "creep": 1e6}
    made |= {"wheel": Wheel(112.0, 700.0, 0.46, 0.725), "axles": 1, "proportional": 0.0, "integral": 0.0}
    made |= {"torque_gain": 0.0, "controller": -np.ones((1, 5)), "feedback": np.zeros((1, 5))}
    loop = loop_stability.Loop(**made)
    loop_stability.growth(loop, loop_stability.rolling_plant(loop))
    assert seen == {"lstsq": {1}, "expm": {1}, "eigvals": {1}}


def job(_number: int, progress) -> set[int]:
    import scipy.linalg  # noqa: F401  loads the other BLAS library

    progress(0.5, "")
    return threads()


@pytest.mark.slow
def test_jobs_of_worker_processes_have_one_thread(monkeypatch) -> None:
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        monkeypatch.setenv(name, "2")
    jobs = {name: Job(job, (0,)) for name in "ab"}
    assert run_rounds(lambda _done: iter([jobs]), None, (1.0,), 2, None)[0] == {"a": {1}, "b": {1}}


def test_an_error_gives_the_setting_back(two_threads) -> None:
    with pytest.raises(ValueError, match="no"), one_blas_thread():
        raise ValueError("no")


SOLVERS = {"eig", "eigvals", "eigh", "eigvalsh", "solve", "lstsq", "inv", "svd", "qr", "expm", "schur", "lu_factor"}


def test_no_module_solves_matrices_without_it() -> None:
    """Every file that uses a solver of NumPy or SciPy does it in `one_blas_thread`."""
    package = Path(rollerrig.__file__).parent
    users = []
    for path in sorted(package.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        if "linalg" not in text:
            continue
        tree = ast.parse(text)
        imported = {
            a.name
            for n in ast.walk(tree)
            if isinstance(n, ast.ImportFrom) and n.module == "scipy.linalg"
            for a in n.names
        }
        of_linalg = {
            node.attr
            for node in ast.walk(tree)
            if isinstance(node, ast.Attribute) and ast.unparse(node.value).endswith("linalg")
        }
        if (imported | of_linalg) & SOLVERS:
            users.append(path.name)
            assert "@one_blas_thread()" in text or "with one_blas_thread():" in text, path
    assert {
        "modes.py",
        "linear_algebra.py",
        "starting_state.py",
        "linear_controller.py",
        "loop_stability.py",
        "signals.py",
    } <= set(users)
