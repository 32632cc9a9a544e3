"""A live simulation at an exhibition: a sentence on what one sees, enlarged displacements, what it does while nobody moves it.

    LiveRun -> [Exhibition] -> caption, enlargement; sliders that it moves itself -> frames of the page

Whether the vehicle hunts is decided by the rule of all studies, from the sideways motion of the leading wheelset.
"""

import math
from collections import deque
from contextlib import suppress
from typing import Any

import numpy as np

from rollerrig.analysis.limit_cycle import Decision, decide_motion
from rollerrig.analysis.signals import final_motion
from rollerrig.cases import leading_wheelset
from rollerrig.config import ConfigError
from rollerrig.simulation.starting_state import StartError
from rollerrig.viewer.live import FRAME, LiveRun

IDLE, ACT = 60.0, 15.0
"""After so long without a visitor it moves itself; so long each of its acts takes [s]."""

ACTS = (0.25, 0.7)
"""Parts of the range of the speed that it shows in turn."""

SEEN, RENEWED = 6.0, 0.5
"""Motion that the caption speaks of, and between two captions [s]."""

PER_FRAME = 3
"""Samples of the motion: 18 in a wave of 5 Hz."""

SLIDES = 0.02
"""Slip of an axle from which on it is said to slide [-]."""

ENLARGED, VISIBLE = (1, 2, 5, 10, 20), 0.06
"""Factors of displacements; the largest is drawn no larger than so [m]."""


class Exhibition:
    """What is said and done of a simulation in front of an audience.

    Attributes:
        caption: a sentence on what one sees.
        enlarged: factor of all displacements.
    """

    def __init__(self, run: LiveRun) -> None:
        self.run, self.caption, self.enlarged = run, "", 1
        self._touched, self._act_began, self._renewed, self._acts = -math.inf, -math.inf, -math.inf, 0
        self._wheelset, self._version = leading_wheelset(run.case).name, run.version
        self._decision: Decision = "open"
        self._seen: deque[tuple[float, float]] = deque(maxlen=round(SEEN * PER_FRAME / FRAME))

    def touched(self) -> None:
        """A visitor did something."""
        self._touched, self._decision = self.run.time, "open"

    def advance(self, seconds: float) -> None:
        """On by so much [s], the simulation too."""
        for _ in range(PER_FRAME):
            self.run.advance(seconds / PER_FRAME)
            self._seen.append((self.run.time, self.run.value(f"{self._wheelset}.lateral") or 0.0))
        time = self.run.time
        if time - max(self._touched + IDLE - ACT, self._act_began) > ACT and not self.run.case.sampled:
            self._act_began = time
            self._next_act()
        if self.run.version != self._version:
            self._version, self._renewed, self._decision = self.run.version, time, "open"
            self._seen.clear()
            self.caption = ""
        if time - self._renewed > RENEWED:
            self._renewed, self.caption = time, self._words()
            largest = max(abs(lateral) for _, lateral in self._seen)
            self.enlarged = max((one for one in ENLARGED if one * largest <= VISIBLE), default=1)

    def frame(self) -> dict[str, Any]:
        """What a frame has beside the simulation's own."""
        return {"caption": self.caption, "enlarged": self.enlarged, "sliders": self.run.values}

    def _next_act(self) -> None:
        """All as at the start, but for the speed, and a push; a speed that the case does not allow is left out."""
        speed, part = self.run.sliders["speed"], ACTS[self._acts % len(ACTS)]
        self._acts += 1
        self.run.again()
        with suppress(ConfigError, StartError, ValueError):
            self.run.set("speed", round(speed.least + part * (speed.most - speed.least)))
            self.run.push()

    def _words(self) -> str:
        train, axle = self.run.value("train.speed"), self.run.value(f"{self._wheelset}.axle_speed")
        at = f"At {3.6 * (train or self.run.value('run.speed') or 0.0):.0f} km/h"
        if train and axle is not None:
            slip = 1.0 - axle * self.run.case.vehicle.data.wheel.radius / train
            if abs(slip) > SLIDES:
                slower = "slower" if slip > 0.0 else "faster"
                return (
                    f"{at} the leading wheels turn {100.0 * abs(slip):.0f} % {slower} than the train runs: they slide."
                )
        time, lateral = np.array(self._seen).T
        found = final_motion(time, lateral)
        if self._decision != "persists":  # once settled it stays so until something is changed
            self._decision = decide_motion(time, lateral)
        if not found.amplitude:
            return f"{at} the vehicle runs straight." if self._decision == "decays" else f"{at}."
        size, often = f"±{1e3 * found.amplitude:.2g} mm", f"{found.frequency:.1f} times a second"
        means = {"persists": ", and goes on: it hunts.", "decays": "; the motion decays.", "open": "."}
        return f"{at} the leading wheelset swings sideways by {size}, {often}{means[self._decision]}"
