"""Measured files: what was written is found again, and every mistake is told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rollerrig.irregularity import IrregularityError, measured_irregularity, read_measured_track

S = np.arange(0.0, 200.01, 0.25)


def write(path: Path, columns: dict[str, np.ndarray], separator: str = ",") -> Path:
    rows = [
        separator.join(columns),
        *(separator.join(map(repr, map(float, row))) for row in zip(*columns.values(), strict=True)),
    ]
    path.write_text("\n".join(rows) + "\n")
    return path


def test_the_four_components_are_found_again(tmp_path: Path) -> None:
    """Waves of 12 m and longer at 0.25 m: the quasi-interpolant is right to (k h)^4/100, here 1e-5."""
    waves = {
        "alignment": lambda x: 3e-3 * np.sin(2 * np.pi * x / 30),
        "vertical": lambda x: 4e-3 * np.cos(2 * np.pi * x / 20),
        "cross_level": lambda x: 2e-3 * np.sin(2 * np.pi * x / 15),
        "gauge": lambda x: 1e-3 * np.cos(2 * np.pi * x / 12),
    }
    path = write(tmp_path / "t.csv", {"distance [m]": S, **{f"{k} [mm]": 1e3 * v(S) for k, v in waves.items()}})
    road = measured_irregularity(read_measured_track(path), start=15.0, needed=(-10.0, 150.0), fade_in=0.0)
    s = np.linspace(-10, 150, 1001)
    for name, found in road.components(s).items():
        exact = waves[name](s + 15.0)
        np.testing.assert_allclose(found, exact, atol=1e-5 * np.abs(exact).max(), err_msg=name)


def test_rails_and_components_are_two_ways_to_say_the_same(tmp_path: Path) -> None:
    y, level = 2e-3 * np.sin(S / 5), 3e-3 * np.cos(S / 7)
    rails = write(
        tmp_path / "r.csv",
        {
            "distance_m": S,
            "left_y_mm": 1e3 * y,
            "right_y_mm": 1e3 * y,
            "left_z_mm": -500 * level,
            "right_z_mm": 500 * level,
        },
        ";",
    )
    components = write(tmp_path / "c.csv", {"distance (km)": S / 1e3, "alignment (m)": y, "cross_level (m)": level})
    commas = tmp_path / "d.csv"
    commas.write_text(rails.read_text().replace(".", ","))
    first, second, third = (read_measured_track(path).rails for path in (rails, components, commas))
    for rail in first:
        np.testing.assert_allclose(first[rail], second[rail], atol=1e-15)
        np.testing.assert_array_equal(first[rail], third[rail])


HEAD = "distance [m], vertical [mm]\n"
ROWS = "".join(f"{0.25 * i}, {i % 3}\n" for i in range(20))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the file is empty; it begins with a line of column names"),
        ("# nothing\n", "the file is empty"),
        ("distance [m], vertcal [mm]\n" + ROWS, "unknown column 'vertcal [mm]'; allowed: distance, and left_y, left_z"),
        (
            "distance, vertical [mm]\n" + ROWS,
            "column 'distance': no unit; allowed: m, mm, km, cm, as in 'distance [mm]'",
        ),
        ("distance [m], vertical [ft]\n" + ROWS, "column 'vertical [ft]': no unit"),
        ("distance [m], distance [m]\n" + ROWS, "column distance stands there twice"),
        (
            "distance [m], left_y [mm]\n" + ROWS,
            "columns distance, left_y; needed: distance, and left_y, left_z, right_y",
        ),
        ("alignment [m], vertical [mm]\n" + ROWS, "columns alignment, vertical; needed: distance"),
        (HEAD + "0, 1, 2\n", "line 2: 3 numbers; the header names 2 columns"),
        (HEAD + "0, x\n", "line 2: '0, x' is not a row of numbers"),
        (HEAD + "0, nan\n", "line 2: '0, nan' is not finite"),
        (HEAD + "0, 1\n1, 2\n", "2 rows; a measured track has at least 8"),
        (HEAD + ROWS + "4.5, 1\n", "the distance must grow: 4.5 m follows 4.75 m"),
        (HEAD + ROWS + "9.5, 1\n", "a gap of 4.75 m after distance 4.75 m"),
        (
            "distance [m], gauge [mm]\n" + "".join(f"{i}, 1437\n" for i in range(20)),
            "a deviation from the nominal gauge",
        ),
    ],
)
def test_a_mistake_is_told(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "t.csv").write_text(text)
    with pytest.raises(IrregularityError) as error:
        read_measured_track(tmp_path / "t.csv")
    assert str(error.value).startswith(f"{tmp_path / 't.csv'}: ")
    assert message in str(error.value)


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(IrregularityError, match=r"no\.csv: cannot be read: No such file"):
        read_measured_track(tmp_path / "no.csv")


@pytest.mark.parametrize(("start", "last"), [(9.9, 100.0), (15.0, 186.0)])
def test_a_file_shorter_than_the_run_is_refused(tmp_path: Path, start: float, last: float) -> None:
    track = read_measured_track(write(tmp_path / "t.csv", {"distance [m]": S, "gauge [mm]": 0 * S}))
    with pytest.raises(
        IrregularityError, match=r"shorter than the run: it reaches from 0 to 200 m, the wheels run from"
    ):
        measured_irregularity(track, start=start, needed=(-10.0, last), fade_in=0.0)
