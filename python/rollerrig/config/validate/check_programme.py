"""Checks across the tables of a test programme: names of stops, and limits that say something about them.

Programme -> [check_programme] -> ConfigProblem, one per mistake
"""

from collections.abc import Iterator
from typing import get_args

from rollerrig.config.errors import ConfigProblem, nearest, one_of, show_value
from rollerrig.config.schema.programme import CRITERIA, CriterionName, Limit, Programme


def check_programme(programme: Programme, file: str) -> list[ConfigProblem]:
    """All mistakes."""
    names = [stop.name for stop in programme.stop]
    found = [
        ConfigProblem(file, f"stop[{number}].name", show_value(name), "allowed: each name once")
        for number, name in enumerate(names)
        if name in names[:number]
    ]
    for number, limit in enumerate(programme.limit):
        mistakes = [*_names(programme, limit, file, f"limit[{number}]")]
        found += mistakes or [*_reach(programme, number, file)]
    return found


def _names(programme: Programme, limit: Limit, file: str, key: str) -> Iterator[ConfigProblem]:
    """Stops that there are not, or in which the train does not stop where it should."""
    stops = {stop.name: stop for stop in programme.stop}
    for name in limit.stops:
        if name not in stops:
            yield ConfigProblem(file, f"{key}.stops", show_value(name), one_of(stops), nearest(name, tuple(stops)))
        elif not limit.holds_for(stops[name]):
            others = ", ".join(other for other in get_args(CriterionName) if not CRITERIA[other].of_a_stop)
            allowed = f"allowed for {limit.criterion}: stops in which the train stops; without that only {others} may be limited"
            yield ConfigProblem(file, f"{key}.stops", show_value(name), allowed)


def _reach(programme: Programme, number: int, file: str) -> Iterator[ConfigProblem]:
    """A limit for no stop, or a second one for the same."""
    limit, key = programme.limit[number], f"limit[{number}].criterion"
    own = [stop for stop in programme.stop if limit.holds_for(stop)]
    if not own:
        allowed = "allowed here: a criterion that does not need a train that stops; no stop of this programme is such"
        yield ConfigProblem(file, key, show_value(limit.criterion), allowed)
    for other in programme.limit[:number]:
        twice = [stop.name for stop in own if other.criterion == limit.criterion and other.holds_for(stop)]
        if twice:
            allowed = f"allowed: one limit of it for {twice[0]}; name in `stops` what each of them holds for"
            yield ConfigProblem(file, key, show_value(limit.criterion), allowed)
            return
