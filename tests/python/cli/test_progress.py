"""Ctrl-C is heard at the next sign of progress, even where Python dropped the exception."""

from __future__ import annotations

import os
import signal

import pytest

from rollerrig.cli.progress import progress_bar


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
