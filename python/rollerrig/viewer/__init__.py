"""The rig in motion: a run as one page that a browser opens from the disk.

    run, another one -> [scene: parts, frames, contact places] -> [page] -> view.html

The page's program is written in `viewer/` at the top of the repository; `scripts/bundle_viewer` makes one file of it.
"""

from rollerrig.viewer.page import view, view_text

__all__ = ["view", "view_text"]
