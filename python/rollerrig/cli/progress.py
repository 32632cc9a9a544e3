"""A progress bar on stderr, only where somebody looks at it; and Ctrl-C, which reaches the work through its progress."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

Progress = Callable[[float, str], None]


@contextmanager
def heard_ctrl_c() -> Iterator[Callable[[], None]]:
    """A function that raises KeyboardInterrupt once more: Python drops one that comes in a callback of the collector."""
    interrupted = False

    def on_interrupt(_signal: int, _frame: FrameType | None) -> None:
        nonlocal interrupted
        interrupted = True
        raise KeyboardInterrupt

    def check() -> None:
        nonlocal interrupted
        if interrupted:
            interrupted = False
            raise KeyboardInterrupt

    if signal.getsignal(signal.SIGINT) is not signal.default_int_handler:  # not the main program, or told to ignore it
        yield check
        return
    before = signal.signal(signal.SIGINT, on_interrupt)
    try:
        yield check
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def progress_bar(title: str, otherwise: Progress | None = None) -> Iterator[Progress]:
    """A function (fraction, text) that moves a bar, or calls `otherwise` if stderr is no terminal."""
    with heard_ctrl_c() as check, _shown(title, otherwise) as show:

        def progress(fraction: float, text: str) -> None:
            check()
            show(fraction, text)

        yield progress


@contextmanager
def _shown(title: str, otherwise: Progress | None) -> Iterator[Progress]:
    if not sys.stderr.isatty():
        yield otherwise or (lambda _fraction, _text: None)
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[text]}"), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(title, total=1.0, text="")
        yield lambda fraction, text: bar.update(task, completed=fraction, text=text)


def lines() -> Progress:
    """Progress as a line on stderr per ten per cent, where there is no terminal for a bar."""
    shown = -1

    def report(fraction: float, text: str) -> None:
        nonlocal shown
        tenth = int(10 * fraction)
        if tenth > shown:
            shown = tenth
            print(f"{10 * tenth:3d} %  {text}", file=sys.stderr)

    return report
