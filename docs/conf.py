"""Sphinx configuration: MyST Markdown, furo, every warning an error (see .ci/run)."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

project = "rollerrig"
author = "The rollerrig authors"
copyright = "The rollerrig authors, Apache-2.0"

extensions = [
    "myst_parser",
    "sphinx.ext.mathjax",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "config_reference",
    "results_reference",
    "api_reference",
]
myst_enable_extensions = ["dollarmath", "amsmath", "deflist", "colon_fence", "attrs_inline"]
myst_heading_anchors = 3
exclude_patterns = ["_build", "reference/generated"]
nitpicky = True
nitpick_ignore_regex = [("py:.*", ".*")]  # names of other libraries and of types in docstrings

html_theme = "furo"
html_title = "rollerrig"
html_copy_source = False
