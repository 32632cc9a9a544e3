"""The command line: ten lines per command over the Python interface.

rollerrig COMMAND ... -> [cli] -> functions of the package -> files, a few printed lines, an exit code
"""

import gc
import sys

__all__ = ["main"]


def main() -> None:
    """Entry point of `rollerrig`; interrupted while it loads its modules, it ends as a command does."""
    # what is loaded is no garbage: looking through it took an eighth of a short command
    gc.set_threshold(50_000, 20, 20)
    try:
        from rollerrig.cli.app import build_app

        build_app()(prog_name="rollerrig")
    except KeyboardInterrupt:
        sys.exit(130)  # termination.INTERRUPTED, which may not be loaded yet
    except BrokenPipeError:  # `rollerrig catalog | head`
        sys.stderr.close()
        sys.exit(1)  # termination.CLOSED
    except Exception as error:  # pydantic makes an error of its own of an interrupt while it builds a model
        if "KeyboardInterrupt" not in str(error):
            raise
        sys.exit(130)
