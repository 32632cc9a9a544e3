"""The command line: ten lines per command over the Python interface.

rollerrig COMMAND ... -> [cli] -> functions of the package -> files, a few printed lines, an exit code
"""

from rollerrig.cli.app import main

__all__ = ["main"]
