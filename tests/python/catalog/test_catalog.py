"""The catalogue: every entry loads, says where its data come from, and still loads once copied to a file."""

from __future__ import annotations

from pathlib import Path

import pytest

from rollerrig.catalog import KINDS, catalog_entries, catalog_file, catalog_names, catalog_text
from rollerrig.config import Rig, Track, load_any, load_case, load_material, load_support, load_vehicle

ENTRIES = [(kind, name) for kind, name, _ in catalog_entries()]


@pytest.mark.parametrize(("kind", "name"), ENTRIES)
def test_an_entry_copied_to_a_file_is_the_same(kind: str, name: str, tmp_path: Path) -> None:
    found_kind, entry = load_any(name)
    assert found_kind == kind
    assert entry.name == name
    assert entry.description
    assert kind in ("case", "plan", "fit") or getattr(entry, "source", "")
    (tmp_path / "copy.toml").write_text(catalog_text(name))
    assert load_any(tmp_path / "copy.toml") == (kind, entry)


def test_names_are_unique_across_kinds() -> None:
    names = [name for _, name in ENTRIES]
    assert len(names) == len(set(names))
    assert {kind for kind, _ in ENTRIES} == set(KINDS)


def test_what_the_project_promises_is_there() -> None:
    assert set(catalog_names("case")) == {
        "bogie_rollers_ramp", "bogie_rollers_constant", "bogie_rollers_traction", "bogie_track", "wheelset_rollers",
        "contact_benchmark_track", "contact_benchmark_rollers", "vehicle_track_irregular", "vehicle_curve", "vehicle_rollers",
        "adhesion_brake", "adhesion_start", "adhesion_step", "adhesion_recovery", "adhesion_lateral", "adhesion_sanding",
        "adhesion_valves", "adhesion_train", "adhesion_coach", "adhesion_coach_valves", "adhesion_rig_as_built",
        "locomotive_traction", "eurosprinter_traction", "sanding_trial",
        "scaled_brake", "cooperrider_bogie", "suspended_wheelset",
    }  # fmt: skip
    assert {"steel", "steel_contact_benchmark", "paper"} <= set(catalog_names("material"))


def test_an_unknown_entry_is_a_key_error() -> None:
    with pytest.raises(KeyError, match="nothing named 'x'"):
        catalog_text("x")
    with pytest.raises(KeyError, match="no case 'x'"):
        catalog_file("case", "x")


def test_the_contact_benchmark_has_a_load_of_20_kn() -> None:
    case = load_case("contact_benchmark_track")
    (wheelset,) = case.vehicle.data.body
    assert wheelset.mass * 9.81 == pytest.approx(20000.0, rel=1e-15)
    assert (case.contact.material.shear_modulus, case.contact.material.poisson_ratio) == (82e9, 0.28)
    rig = load_case("contact_benchmark_rollers").support.data
    assert isinstance(rig, Rig)
    assert rig.roller_radius == 0.725
    assert rig.profile == case.support.data.profile


def test_rig_and_track_differ_by_the_radius_only() -> None:
    rig, track = load_support("full_scale_rig"), load_support("uic60_track")
    assert isinstance(track, Track)
    assert (rig.profile, rig.gauge, rig.gauge_depth) == (track.profile, track.gauge, track.gauge_depth)


def test_the_paper_s_material_is_an_eighth_of_steel() -> None:
    assert load_material("paper").shear_modulus == 1e10
    assert load_material("steel").shear_modulus == pytest.approx(8.2e10, rel=1e-3)  # 210 GPa / 2.56


def test_the_vehicle_s_load_is_the_published_one() -> None:
    vehicle = load_vehicle("manchester_vehicle_1")
    weight = sum(body.mass for body in vehicle.body) * 9.81
    assert weight / 8 == pytest.approx(54.55e3, abs=5)  # published with four digits
