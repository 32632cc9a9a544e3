"""The gauge of a support that gives the distance of the contacts of the centred wheelset in its place.

    wheel, head, abscissa on the wheel -> [place_under] -> where the head lies under the wheel -> [with_gauge] -> gauge

In the middle, without yaw and roll, a wheel touches its rail or roller where the gap between their sections across the track is
least. The further outside the head lies, the further outside that is: a bisection ends at the place asked for, or at a jump.
"""

import math
from functools import lru_cache

import numpy as np

from rollerrig.config.errors import ConfigProblem, show_value
from rollerrig.config.schema.support import Rig
from rollerrig.config.schema.track import Track
from rollerrig.config.schema.vehicle import Wheel
from rollerrig.profiles import ProfileTable, gauge_point, profile_from_spec

POINTS = 5001  # of the wheel, between which the least gap is that of a parabola
CLOSE = 5e-6  # [m] from the contact asked for; further off there is a jump between two contacts, or an end of a profile


def with_gauge(support: Rig | Track, wheel: Wheel, file: str) -> tuple[Rig | Track, list[ConfigProblem]]:
    """The support with the gauge that its `contact_distance`, if it has one, asks for under these wheels."""
    if support.contact_distance is None:
        return support, []
    tread = profile_from_spec(wheel.profile.arguments(), "wheel")
    head = profile_from_spec(support.profile.arguments(), "rail")
    tape_circle = wheel.back_to_back / 2 + wheel.tape_circle
    asked = support.contact_distance / 2 - tape_circle
    place, *contacts = place_under(tread, head, asked)
    if any(abs(contact - asked) > CLOSE for contact in contacts):
        near = " or ".join(f"{2e3 * (tape_circle + s):.2f} mm" for s in contacts if math.isfinite(s))
        allowed = f"no gauge has contacts of these profiles so far apart; allowed nearest to it: {near or 'none'}"
        written = show_value(support.contact_distance)
        return support, [ConfigProblem(file, "support.data.contact_distance", written, allowed)]
    gauge = 2 * (tape_circle + place + gauge_point(head, support.gauge_depth))
    if gauge != support.gauge:
        support = support.model_copy(update={"gauge": gauge})
        support.model_fields_set.discard("gauge")  # it is still not given
    return support, []


@lru_cache(maxsize=64)
def place_under(tread: ProfileTable, head: ProfileTable, asked: float) -> tuple[float, float, float]:
    """Abscissa on the wheel over the head's highest point for a contact at `asked`, and the last contacts found on either side.

    All lengths are in metres; a side on which there is none has an infinite one.
    """
    wheel = np.linspace(*tread.domain, POINTS)
    first, last = head.domain
    low, high, below, above = wheel[0] - last, wheel[-1] - first, -math.inf, math.inf
    while low < (place := (low + high) / 2) < high:
        s = wheel[(wheel >= place + first) & (wheel <= place + last)]
        gap = -(tread.evaluate(s) + head.evaluate(s - place))
        k = int(np.argmin(gap))
        if 0 < k < len(s) - 1:
            before, least, after = gap[k - 1 : k + 2]
            contact = s[k] + (s[k + 1] - s[k]) / 2 * (before - after) / (before - 2 * least + after)
        else:  # the end of a profile is no contact
            contact = -math.inf if k == 0 else math.inf
        if contact < asked:
            low, below = place, contact
        else:
            high, above = place, contact
    return float(high), float(below), float(above)
