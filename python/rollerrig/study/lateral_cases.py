"""The cases of the lateral study beside the rig itself: control runs on track, and the same run started a little differently.

Case -> [lateral_cases] -> Case

On track two things can end hunting where the rail is bad: the wheels slide, or the creep curve of the contaminated rail is less
steep (k_A, k_S). The control runs take one of them away at a time.
"""

from __future__ import annotations

from rollerrig.config import Case, Condition

MEMBERS = 8
"""Runs of an ensemble, the case itself included."""

NEARLY = 1e-9
"""Relative change of the disturbance from one member to the next: below what any measurement could tell."""

CLEAN_POLACH = {"kind": "polach", "k_A": 1.0, "k_S": 1.0}
"""Polach's creep law on a clean surface."""


def unbraked(case: Case) -> Case:
    """The same run without brake and traction: no wheel slides."""
    tables = {name: table for name in ("brake", "traction") if (table := getattr(case, name)) is not None}
    none = {name: table.model_copy(update={"demand": ((0.0, 0.0), (1.0, 0.0))}) for name, table in tables.items()}
    return case.model_copy(update=none)


def whole_creep_slope(case: Case) -> Case:
    """The same rail with k_A = k_S = 1: as little friction, but a creep curve as steep as on a clean rail."""
    assert case.adhesion is not None

    def steep(rail: Condition) -> Condition:
        return rail.model_copy(update={"k_A": 1.0, "k_S": 1.0})

    pieces = tuple(piece.model_copy(update={"rail": steep(piece.rail)}) for piece in case.adhesion.piece)
    adhesion = case.adhesion.model_copy(update={"rail": steep(case.adhesion.rail), "piece": pieces})
    return case.model_copy(update={"adhesion": adhesion})


def nearly_the_same(case: Case) -> list[Case]:
    """The other members of the ensemble of a case, each displaced by 1e-9 more than the one before."""
    members = []
    for number in range(1, MEMBERS):
        larger = 1.0 + NEARLY * number
        disturbance = tuple(
            one.model_copy(update={"lateral": larger * one.lateral, "yaw": larger * one.yaw})
            for one in case.disturbance
        )
        members.append(case.model_copy(update={"disturbance": disturbance}))
    return members
