"""Ctrl-C is noted at once and raised at the next sign of progress; times are shown as soon as they are known."""

from __future__ import annotations

import os
import signal

import pytest

from rollerrig.cli.progress import TimeLeft, duration, interrupts_noted, lines, progress_bar


class Careless:
    def __del__(self) -> None:
        os.kill(os.getpid(), signal.SIGINT)


def test_an_interrupt_is_noted_wherever_it_comes_and_raised_with_the_progress() -> None:
    """Also in a callback of the collector, where Python drops exceptions; the second one ends the program."""
    with interrupts_noted() as handler, progress_bar("title", handler) as progress:
        progress(0.0, "")
        careless = Careless()
        del careless
        for _ in range(2):
            with pytest.raises(KeyboardInterrupt):
                progress(0.5, "")
        with pytest.raises(SystemExit, match="130"):
            os.kill(os.getpid(), signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


def test_the_time_left_is_shown_when_it_is_known_and_never_jumps() -> None:
    """Twelve minutes of which the first two per cent take a fifth: hours are never shown, and in the end it is right."""
    clock, shown = Clock(), {}
    left = TimeLeft(clock)
    for second in range(721):
        clock.now = float(second)
        shown[second] = left(0.02 * second / 144 if second < 144 else 0.02 + 0.98 * (second - 144) / 576)
    assert not any(shown[second] for second in range(144))  # nothing while it would be a guess
    assert not [text for text in shown.values() if " h" in text]
    assert shown[360] == "about 9 min left"  # 39 % done: 9.5 min by the average, 6 in truth
    assert (shown[650], shown[720]) == ("about 90 s left", "")


def test_finished_jobs_that_are_taken_over_do_not_count_as_speed() -> None:
    clock = Clock()
    left = TimeLeft(clock)
    left(0.0)
    left(0.5)  # at the same moment: half of the jobs were finished before
    for second in range(1, 101):
        clock.now = float(second)
        text = left(0.5 + 0.0025 * second)
    assert text == "about 2 min left"  # a quarter more in 100 s; a quarter is left


def test_a_log_has_a_line_per_part_and_few_of_a_night(capsys: pytest.CaptureFixture[str]) -> None:
    """Also while a tenth of the whole takes minutes; nothing for what is done at once."""
    clock = Clock()

    def logged(begin: int, seconds: int, whole: float, text: str) -> list[str]:
        clock.now = float(begin)
        report = lines(clock)
        for second in range(seconds):
            clock.now = float(begin + second)
            report(second / whole, text.format(second // 60, second))
        return capsys.readouterr().err.splitlines()

    slow = logged(0, 360, 1e4, "job")
    assert len(slow) == 24
    assert (slow[0], slow[-1]) == ("  0 %  (5 s so far)  job", "  3 %  (6 min so far)  job")
    assert logged(0, 2, 1.0, "job") == []
    parts = logged(0, 300, 300.0, "part {0}")
    assert {line.rpartition("  ")[2] for line in parts} == {f"part {number}" for number in range(5)}
    assert len(parts) < 30
    assert 50 < len(logged(300, 43_200, 43_200.0, "{1} of 43200 cases")) < 400


@pytest.mark.parametrize(
    ("seconds", "text"), [(1.0, "5 s"), (42.0, "40 s"), (95.0, "2 min"), (3540.0, "59 min"), (9000.0, "2.5 h")]
)
def test_times_are_written_as_people_say_them(seconds: float, text: str) -> None:
    assert duration(seconds) == text
