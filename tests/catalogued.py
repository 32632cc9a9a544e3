"""Profiles of the catalogue as tables, for tests."""

from __future__ import annotations

from rollerrig.config import load_profile
from rollerrig.profiles import ProfileKind, ProfileTable, profile_from_spec


def profile_table(name: str, kind: ProfileKind) -> ProfileTable:
    return profile_from_spec(load_profile(name).arguments(), kind)
