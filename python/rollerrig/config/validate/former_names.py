"""Keys and words of earlier versions, and where each went."""

from collections.abc import Mapping, Sequence

from rollerrig.config.errors import nearest

_RENAMED: Mapping[str, tuple[str, ...]] = {
    "anti_skid": ("slide_protection",),
    "anti_slip": ("wheel_slip_control",),
    "believed": ("assumed",),
    "cleaned": ("recovered",),
    "cleaning": ("recovery_constant",),
    "decay": ("B", "beta", "friction"),
    "friction_fall": ("friction",),
    "held": ("fixed", "speed_controlled"),
    "ideal_rolling": ("pure_rolling",),
    "initial": ("k_0",),
    "luenberger": ("observer",),
    "merge_barrier": ("merging_criterion", "normal.merging_criterion"),
    "polach": ("creep",),
    "ratio": ("A",),
    "remaining": ("A", "friction"),
    "saturate_spin_moment": ("creep.saturate_spin_moment",),
    "slip_reduction": ("k_S",),
    "standstill_speed": ("creepage_regularisation_speed", "friction_regularisation_speed"),
    "start": ("mu_0", "friction"),
    "stick_reduction": ("k_A",),
    "stiffness_reduction": ("creep",),
    "ultimate": ("k_inf",),
    "wsp": ("slide_protection",),
}
"""Former key or word -> what it may be called now; a dotted one is in a table of that name."""

_DIVIDED: Mapping[str, str] = {
    "bench": "its step is now time.sampling_step, its standstill motion.stop_speed, its pure_rolling contact.pure_rolling"
}
"""Former table -> where each of its keys went."""


def meant(word: object, choices: Sequence[str]) -> str:
    """The present name of a renamed key or word, or the nearest of those allowed; "" if nothing is near."""
    present = (new for new in _RENAMED.get(str(word).lower(), ()) if new.split(".")[0] in choices)
    return next(present, "") or nearest(word, choices)


def divided(word: object) -> str:
    """Where the keys of a former table went, "" if it was none."""
    return _DIVIDED.get(str(word), "")
