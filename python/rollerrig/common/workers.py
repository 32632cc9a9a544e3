"""Worker processes end with the program that started them, also where it is killed.

    a worker begins -> [begin] -> it ends when its parent does

A worker that waits for its next job waits for ever: it holds both ends of the queue itself. Two watches that do not depend on
each other end it: on Linux the kernel kills it at once; everywhere, a thread that waits for the end of the pipe that only the
parent keeps open. The second also meets a parent that died before the worker could ask for either.
"""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import signal
import sys
import threading
from importlib import import_module
from multiprocessing.connection import wait
from typing import Any

_PR_SET_PDEATHSIG = 1  # <linux/prctl.h>
ORPHANED = 1
"""Exit code of a worker whose parent is gone; nobody is left to read it."""


def begin(module: str, function: str, *arguments: Any) -> None:
    """What a worker does first: this module needs nothing, so that it watches its parent before the seconds of loading others.

    Args:
        module: loaded next.
        function: of that module, called with
        arguments: of its.
    """
    end_with_parent()
    getattr(import_module(module), function)(*arguments)


def end_with_parent() -> None:
    """End this process when the one that started it ends; nothing in the main process.

    To be called on the main thread of a worker. A call into the core that holds the interpreter is ended by the kernel; where
    there is no such service the worker ends after that call.
    """
    parent = multiprocessing.parent_process()
    if parent is None:
        return
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)

    def watch() -> None:
        wait([parent.sentinel])
        os._exit(ORPHANED)  # no farewell: what it would be said to is gone

    threading.Thread(target=watch, name="parent watch", daemon=True).start()
