"""Jobs in one process and in several give the same; Ctrl-C keeps what is done."""

from __future__ import annotations

from rollerrig.analysis.parallel import Progress, run_jobs


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


def test_several_processes_give_the_same() -> None:
    # a function of the package: a fresh process cannot import this test module by name
    from rollerrig.analysis.signals import half_waves  # noqa: F401 - the import that each process pays for
    from rollerrig.study.jobs import call, job, whole_run
    from rollerrig.study.paper_plan import QUICK, traction_case

    short = traction_case(QUICK).with_changes({"time.duration": "0.2 s"})
    jobs = [job(whole_run, short)] * 2
    one, two = run_jobs(call, jobs[:1]), run_jobs(call, jobs, processes=2)
    assert all(result is not None and result.identical(one.results[0]) for result in two.results)


def test_each_result_is_handed_over_as_soon_as_it_is_there() -> None:
    kept: dict[int, int] = {}
    run_jobs(interrupted_at_three, [1, 2, 3, 4], keep=kept.__setitem__)
    assert kept == {0: 1, 1: 2}
