"""The same test on a full-scale rig and on a scaled one, mapped back."""

from rollerrig.studies.scaled.words import lead

__all__ = ["lead"]
