"""What a key means, in words."""

from __future__ import annotations

import pytest

from rollerrig.config import explain
from rollerrig.config.write.explain import key_places


def test_every_key_is_explained() -> None:
    texts = {key: explain(key) for key in {place.key for place in key_places()}}
    for place in key_places():
        assert place.key in texts[place.key]
        assert place.field.description in texts[place.key]


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("motion.speed", ["unit       m/s", "this or 'speed_table'", "from 0 to 200 m/s", "[motion] of a case"]),
        ("vehicle.element.primary_1_left.x.stiffness", ["vehicle.element.x.stiffness", "N/m", "manchester_vehicle_1"]),
        ("vehicle.data.body[0].mass", ["vehicle.body.mass", "unit       kg", "it must be given"]),
        ("contact.creep", ["kalker_saturated, ", "'polach': kind, k_A, k_S", "default    'table'"]),
        ("output_step", ["time.output_step", "0.01"]),
        ("stiffness", ["15 keys end in 'stiffness'", "vehicle.element.yaw.stiffness "]),
        ("stop.speed", ["of a programme", "slide_protection_stops"]),
        ("slide_protection.fmu", ["a text or a table", "of kind 'slip_and_deceleration' or 'threshold_table' of a case"]),
        ("support.mounting.misalignment", ["a list, each a number in rad", "none: empty"]),
        ("vehicle.body.position", ["a list of 3, each a number in m"]),
        ("contact.friction", ["a number or a table of a kind: constant, falling"]),
        ("adhesion.rail", ["dry, eurosprinter, wet, low, very_low or a table"]),
        ("vehicle.element.at", ["tables by name"]),
        ("slide_protection", ["the name of a kind or a table of a kind: slip_and_deceleration, threshold_table"]),
        ("sensors.axles.window", ["a whole number, from 1 to 16"]),
        ("vary.count", ["a whole number, at least 2"]),
        ("support.irregularity.seed", ["from 0 to 4294967295"]),
        ("sensors.axles.pitch_error", ["a tooth's place, in pitches; the same in each turn"]),
        ("base", ["loading writes that into it"]),
        ("starts", ["the case's own values, and spread over the ranges"]),
        ("vehicle.body.inertia", ["through the centre of mass"]),
        ("brake.friction_radius", ["of a tread brake the wheel radius"]),
        ("motion.speed_table", ["a list, each a list of 2, each a number in s", "; then a number in m/s", "unit       s, m/s"]),
    ],
)  # fmt: skip
def test_a_key_is_explained(key: str, words: list[str]) -> None:
    text = explain(key)
    for word in words:
        assert word in text


def test_nothing_is_said_twice() -> None:
    for key in ("fmu", "slide_protection.sample_time", "friction"):
        blocks = explain(key).split("\n\n")
        assert len({block.splitlines()[0] for block in blocks}) == len(blocks)


@pytest.mark.parametrize(
    ("words", "first", "among"),
    [
        ("polach", "contact.creep", "contact.friction.kind"),
        ("contact.law", "contact.creep", "contact.normal"),
        ("wheel load", "wheel_slip_control", "train.axles.loads"),
    ],
)
def test_words_that_are_no_key_are_looked_for_in_names_and_texts(words: str, first: str, among: str) -> None:
    head, *rows = explain(words).splitlines()
    assert head == f"no key is called '{words}'; these speak of it:"
    assert rows[0].split()[0] == first
    assert among in [row.split()[0] for row in rows]


@pytest.mark.parametrize(
    ("key", "line"),
    [
        ("motion.sped", "motion.sped: no such key; did you mean 'motion.speed'?"),
        (
            "sped",
            "sped: no such key; did you mean 'motion.speed' or 'ensemble.speed' or 'stop.speed' or 'measure.stop.speed'?",
        ),
        (
            "yaw_stiffness",
            "yaw_stiffness: no such key; did you mean 'vehicle.element.yaw.stiffness' or 'support.mounting.yaw.stiffness'?",
        ),
        ("mounting.stifness", "mounting.stifness: no such key; did you mean 'support.mounting.yaw.stiffness'?"),
        ("anti_skid", "anti_skid: no such key; did you mean 'slide_protection'?"),
        ("qqqq", "qqqq: no such key; rollerrig schema prints all keys"),
    ],
)
def test_an_unknown_key_is_answered_with_the_nearest(key: str, line: str) -> None:
    with pytest.raises(KeyError) as error:
        explain(key)
    assert error.value.args[0] == line
