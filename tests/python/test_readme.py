"""What the README and the first pages of the documentation name is there; their code is run by docs/test_blocks.py."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", ROOT / "docs" / "getting_started.md"]


def test_every_case_shown_ships() -> None:
    import rollerrig

    text = "".join(page.read_text() for page in PAGES)
    names = set(re.findall(r"rollerrig (?:run|stability|contact|catalog show) ([a-z]+_[a-z_]+)\b(?!\.toml)", text))
    assert names
    for name in names:
        rollerrig.load_case(name)


def test_every_local_link_leads_somewhere() -> None:
    for page in [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]:
        for link in re.findall(r"\]\((?!https?://|#)([^)#]+)", page.read_text()):
            if "generated" not in page.parts:
                assert (page.parent / link).exists(), f"{page.relative_to(ROOT)} links to {link}"
