"""Ctrl-C is heard at the next sign of progress, even where Python dropped the exception."""

from __future__ import annotations

import os
import signal

import pytest

from rollerrig.cli.progress import TimeLeft, duration, lines, progress_bar


class Careless:
    def __del__(self) -> None:
        os.kill(os.getpid(), signal.SIGINT)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_dropped_interrupt_is_raised_again() -> None:
    with progress_bar("title") as progress:
        progress(0.0, "")
        careless = Careless()
        del careless  # the handler runs here, and its exception is dropped
        with pytest.raises(KeyboardInterrupt):
            progress(0.5, "")
        progress(1.0, "")
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


class Clock:
    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def test_the_time_left_is_told_when_it_is_known_and_never_jumps() -> None:
    """Twelve minutes of which the first two per cent take a fifth: hours are never told, and in the end it is right."""
    clock, told = Clock(), {}
    left = TimeLeft(clock)
    for second in range(721):
        clock.now = float(second)
        told[second] = left(0.02 * second / 144 if second < 144 else 0.02 + 0.98 * (second - 144) / 576)
    assert not any(told[second] for second in range(144))  # nothing while it would be a guess
    assert not [text for text in told.values() if " h" in text]
    assert told[360] == "about 9 min left"  # 39 % done: 9.5 min by the average, 6 in truth
    assert told[650] == "about 90 s left"
    assert told[720] == ""


def test_finished_jobs_that_are_taken_over_do_not_count_as_speed() -> None:
    clock = Clock()
    left = TimeLeft(clock)
    left(0.0)
    left(0.5)  # at the same moment: half of the jobs were finished before
    for second in range(1, 101):
        clock.now = float(second)
        text = left(0.5 + 0.0025 * second)
    assert text == "about 2 min left"  # a quarter more in 100 s; a quarter is left


def test_a_pipe_gets_a_line_now_and_then(capsys: pytest.CaptureFixture[str]) -> None:
    """Also while a tenth of the whole takes minutes; nothing for what is done at once."""
    clock = Clock()
    report = lines(clock)
    for second in range(360):
        clock.now = float(second)
        report(0.0001 * second, "job")
    told = capsys.readouterr().err.splitlines()
    assert len(told) == 24
    assert told[0] == "  0 %  (5 s so far)  job"
    assert told[-1] == "  3 %  (6 min so far)  job"
    brief = lines(clock)
    for tenth in range(11):
        brief(0.1 * tenth, "job")
    assert capsys.readouterr().err == ""


def test_a_log_has_a_line_per_part_and_few_of_a_night(capsys: pytest.CaptureFixture[str]) -> None:
    clock = Clock()
    report = lines(clock)
    for second in range(300):  # five parts of a minute
        clock.now = float(second)
        report(second / 300, f"part {second // 60}")
    told = capsys.readouterr().err.splitlines()
    assert {line.rpartition("  ")[2] for line in told} == {f"part {number}" for number in range(5)}
    assert len(told) < 30
    report = lines(clock)
    for second in range(300, 300 + 43_200):  # a sweep, whose text is another one each time
        clock.now = float(second)
        report((second - 300) / 43_200, f"{second} of 43200 cases")
    told = capsys.readouterr().err.splitlines()
    assert 50 < len(told) < 400


@pytest.mark.parametrize(
    ("seconds", "text"), [(1.0, "5 s"), (42.0, "40 s"), (95.0, "2 min"), (3540.0, "59 min"), (9000.0, "2.5 h")]
)
def test_times_are_told_as_people_do(seconds: float, text: str) -> None:
    assert duration(seconds) == text
