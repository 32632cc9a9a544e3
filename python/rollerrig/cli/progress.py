"""How far a command is: a bar on a terminal, lines now and then in a pipe; and Ctrl-C, which reaches the work through it.

fraction, text -> [progress_bar] -> bar, or a line per part of the work, with the time left as soon as it can be estimated
first Ctrl-C -> reported at once, KeyboardInterrupt at the next progress; second Ctrl-C -> the command ends there and then
"""

import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType

from rollerrig.cli.termination import INTERRUPTED

Progress = Callable[[float, str], None]
Clock = Callable[[], float]

REPORT_SECONDS, PART_SECONDS = 15.0, 2.0
"""Between two lines where there is no terminal, and before the first of a new part of the work; what takes less prints none."""

REPORT_SHARE, PART_SHARE = 0.02, 0.05
"""The same as parts of the time so far: a log of a night has hundreds of lines, not thousands."""

LEAST_GAINED, LEAST_SECONDS = 0.1, 10.0
"""The time left is shown when so much of the whole is done, and so long after the begin [s]."""

JUMP, JUMP_SECONDS = 0.02, 0.05
"""More of the whole within so many seconds was not computed now but taken over."""

STOPPING = """
Interrupted, writing results: jobs at work are given up. Ctrl-C again ends at once and leaves what is there.
"""


class InterruptHandler:
    """Handler of Ctrl-C: the first one is noted, so that no result is lost; the second one ends the program; `times` pressed."""

    def __init__(self) -> None:
        self.times = 0

    def __call__(self, _signal: int, _frame: FrameType | None) -> None:
        """Note it.

        Raises:
            SystemExit: the second time; nothing catches it, and files under their temporary names are removed on its way.
        """
        self.times += 1
        if self.times > 1:
            raise SystemExit(INTERRUPTED)
        os.write(2, STOPPING.encode())  # `print` may be at work itself


@contextmanager
def interrupts_noted() -> Iterator[InterruptHandler]:
    """Within it, Ctrl-C is handled by InterruptHandler, unless this is not the main program or ignores Ctrl-C."""
    handler = InterruptHandler()
    if signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield handler
        return
    signal.signal(signal.SIGINT, handler)
    try:
        yield handler
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@contextmanager
def progress_bar(title: str, handler: InterruptHandler) -> Iterator[Progress]:
    """A function (fraction, text) that moves a bar, or prints lines where stderr is no terminal.

    It raises KeyboardInterrupt once Ctrl-C was pressed.
    """
    with _shown(title) as show:

        def progress(fraction: float, text: str) -> None:
            if handler.times:
                raise KeyboardInterrupt
            show(fraction, text)

        yield progress


@contextmanager
def _shown(title: str) -> Iterator[Progress]:
    if not sys.stderr.isatty():
        yield lines()
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn

    columns = [TextColumn(text) for text in ("{task.description}", "{task.fields[text]}", "{task.fields[left]}")]
    left = TimeLeft()
    with Progress(columns[0], BarColumn(), *columns[1:], console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(title, total=1.0, text="", left="")
        yield lambda fraction, text: bar.update(task, completed=fraction, text=text, left=left(fraction))


class TimeLeft:
    """The time left from the average since the begin: no jumping about with the last job, and nothing while it is a guess.

    The estimates of rich's and tqdm's columns follow the last jobs and count what was taken over as speed.
    """

    def __init__(self, clock: Clock = time.monotonic) -> None:
        self._clock = clock
        self._begun: float | None = None
        self._last = (0.0, 0.0)
        self._taken_over = 0.0

    def __call__(self, fraction: float) -> str:
        """'about 4 min left', or nothing while too little is done to tell."""
        now = self._clock()
        if self._begun is None:
            self._begun, self._taken_over = now, fraction
        elif now - self._last[0] < JUMP_SECONDS and fraction - self._last[1] > JUMP:
            self._taken_over += fraction - self._last[1]
        self._last = (now, fraction)
        elapsed, gained = now - self._begun, fraction - self._taken_over
        if gained < LEAST_GAINED or elapsed < LEAST_SECONDS or fraction >= 1.0:
            return ""
        return f"about {duration(elapsed * (1.0 - fraction) / gained)} left"


def duration(seconds: float) -> str:
    """A time as people say it: '40 s', '12 min', '2.5 h'."""
    if seconds < 90.0:
        return f"{max(5, 5 * round(seconds / 5.0))} s"
    return f"{round(seconds / 60.0)} min" if seconds < 5400.0 else f"{seconds / 3600.0:.1f} h"


def lines(clock: Clock = time.monotonic) -> Progress:
    """Lines on stderr, one per part of the work and now and then: how much is done, since when, what is left, what is running."""
    begun = last = clock()
    left, part = TimeLeft(clock), ""

    def report(fraction: float, text: str) -> None:
        nonlocal last, part
        remaining, now = left(fraction), clock()
        usual = max(REPORT_SECONDS, REPORT_SHARE * (now - begun))
        if now - last < (usual if text == part else min(usual, max(PART_SECONDS, PART_SHARE * (now - begun)))):
            return
        last, part = now, text
        times = ", ".join(filter(None, (f"{duration(now - begun)} so far", remaining)))
        with suppress(BrokenPipeError):  # the reader has ended (`2>&1 | head`): the work continues
            print(f"{int(100 * fraction):3d} %  ({times})  {text}".rstrip(), file=sys.stderr, flush=True)

    return report
