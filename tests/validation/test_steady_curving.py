"""Steady curving against statics written out here, the end of a run in a long curve, its mirror image and the straight."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import rollerrig as rr
from rollerrig.analysis.curving import curving_case, curving_speed, follow, recorded, solve
from rollerrig.assembly.model import assemble
from rollerrig.config import Case
from rollerrig.simulation.starting_state import equilibrium_dataset

CANT, BASE, G = 0.1, 1.5, 9.81
WAGON = Path(__file__).parents[1] / "python" / "two_axle_wagon.toml"


def of(name: str | Path, friction: float = 0.3) -> Case:
    return rr.load_case(name).with_changes(
        {"contact.normal": "strips", "contact.creep": "table", "contact.friction": friction, "support.foundation": None}
    )


def steady(case: Case, radius: float, deficiency: float) -> xr.Dataset:
    """What a run records, in the steady state of a curve to the left."""
    bare = curving_case(case)
    end = np.array([1 / radius, CANT, curving_speed(bare, radius, CANT, deficiency)])
    last, why = follow(bare, solve(bare, end * [0.0, 0.0, 1.0], "left"), end, "left")
    assert why == ""
    return recorded([last]).isel(time=0)


def mass_of(case: Case) -> float:
    return sum(body.mass for body in case.vehicle.data.body)


def contact_moments(found: xr.Dataset, wheelset: str) -> float:
    """Of the rails on a wheelset about the vertical axis through its middle, patch by patch [N m].

    The contacts turn with the yaw ψ; one on an inclination δ leads by r tan δ ψ.
    """
    yaw, total = float(found["yaw"].sel(body=wheelset)), 0.0
    for side, sign in (("left", 1.0), ("right", -1.0)):
        at = found.sel(wheel=f"{wheelset}_{side}").fillna(0.0)
        names = ("wheel_abscissa", "contact_angle", "normal", "creep_force_x", "creep_force_y")
        abscissa, angle, normal, along, across = (at[f"patch_{name}"].to_numpy() for name in names)
        across = across * np.cos(angle) - sign * normal * np.sin(angle)
        assert across.sum() == pytest.approx(float(at["lateral_force"]), rel=1e-9)
        y = sign * (0.75 + abscissa)
        x = yaw * (sign * float(at["rolling_radius"]) * np.tan(angle) - y)
        total += float((x * across - y * along).sum()) + float(at["spin_moment"])
    return total


def turned(found: xr.Dataset, body: str, place: float, radius: float) -> float:
    """Yaw of a body against the car body; the track turns by x / R about the vertical, in its plane by the cosine of the cant."""
    heading = place / radius * math.cos(math.asin(CANT / BASE))
    return float(found["yaw"].sel(body=body)) + heading - float(found["yaw"].sel(body="car_body"))


def lateral_force(found: xr.Dataset, wheelset: str) -> float:
    """Of the rails on a wheelset, to the left [N]."""
    return sum(float(found["lateral_force"].sel(wheel=f"{wheelset}_{side}")) for side in ("left", "right"))


CURVES = [(500.0, 0.06, 0.3), (300.0, 0.15, 0.3), (300.0, 0.06, 0.1), (300.0, -0.06, 0.1)]


@pytest.mark.parametrize(("radius", "deficiency", "friction"), CURVES)
def test_forces_balance_cant_deficiency_and_weight(radius: float, deficiency: float, friction: float) -> None:
    """Sum of Y = m g I / b; sum of Q = m (g cos + v²/R sin): bodies lie up to 0.1 % beside the line's direction."""
    case = of("vehicle_curve", friction)
    found = steady(case, radius, deficiency)
    mass, phi, speed = mass_of(case), math.asin(CANT / BASE), float(found["speed"])
    assert speed**2 / radius * math.cos(phi) == pytest.approx(G * (deficiency + CANT) / BASE, rel=1e-12)
    assert float(found["lateral_force"].sum()) == pytest.approx(mass * G * deficiency / BASE, rel=2e-3)
    normal = G * math.cos(phi) + speed**2 / radius * math.sin(phi)
    assert float(found["vertical_force"].sum()) == pytest.approx(mass * normal, rel=1e-3)


@pytest.mark.parametrize(("radius", "deficiency", "friction"), CURVES)
def test_the_load_moves_to_the_outer_rail(radius: float, deficiency: float, friction: float) -> None:
    """Moments about the tangent in the wagon's middle, of forces on bodies and wheels and of wheelsets that turn with the curve.

    Wheelsets lie x²/(2R) beside the tangent. 0.1 % of the weight on half the base.
    """
    case = of(WAGON, friction)
    found, model = steady(case, radius, deficiency), assemble(curving_case(case))
    phi, speed = math.asin(CANT / BASE), float(found["speed"])
    normal = G * math.cos(phi) + speed**2 / radius * math.sin(phi)

    def beside(name: str) -> float:
        return float(found["lateral"].sel(body=name)) + model.positions[name][0] ** 2 / (2 * radius) * math.cos(phi)

    outward = carried = 0.0
    for body in case.vehicle.data.body:
        height = body.position[2] + float(found["vertical"].sel(body=body.name))
        outward += body.mass * (G * deficiency / BASE * height - normal * beside(body.name))
        spin = float(found["pitch_rate"].sel(body=body.name))
        outward += (
            body.inertia[1] * spin * speed / radius * math.cos(phi)
        )  # the angular momentum points to the left, and turns
    for wheel in model.wheels:
        at, sign = found.sel(wheel=wheel.name), 1.0 if wheel.side == "left" else -1.0
        roll, axle = (float(found[name].sel(body=wheel.wheelset)) for name in ("roll", "vertical"))
        out = sign * (0.75 + float(at["contact_abscissa"]))
        height = 0.46 + axle + out * roll - float(at["rolling_radius"])
        carried += height * float(at["lateral_force"]) - (out + beside(wheel.wheelset)) * float(at["vertical_force"])
    assert carried == pytest.approx(outward, abs=1e-3 * 0.75 * mass_of(case) * G)


@pytest.mark.parametrize(("radius", "deficiency", "friction"), CURVES)
def test_creep_flange_and_secondary_moments_on_a_bogie_balance(
    radius: float, deficiency: float, friction: float
) -> None:
    """A bogie of 2.56 m wheelbase under secondary springs of 160 kN/m along at 1 m on either side; all else turns freely."""
    found = steady(of("vehicle_curve", friction), radius, deficiency)
    for frame, place, (leading, trailing) in (
        ("front_frame", 9.5, ("wheelset_1", "wheelset_2")),
        ("rear_frame", -9.5, ("wheelset_3", "wheelset_4")),
    ):
        springs = -2 * 160e3 * 1.0**2 * turned(found, frame, place, radius)
        couple = 1.28 * (lateral_force(found, leading) - lateral_force(found, trailing))
        creep = contact_moments(found, leading) + contact_moments(found, trailing)
        assert springs + couple + creep == pytest.approx(0.0, abs=40.0)  # of up to 15 kN m


@pytest.mark.parametrize(("radius", "deficiency", "friction"), CURVES)
def test_primary_springs_turn_each_wheelset_against_creep(radius: float, deficiency: float, friction: float) -> None:
    """Of the wagon: 4 MN/m along at 1 m on either side, 4 m before and behind the middle."""
    found = steady(of(WAGON, friction), radius, deficiency)
    for name, x in (("wheelset_1", 4.0), ("wheelset_2", -4.0)):
        springs = -2 * 4e6 * 1.0**2 * turned(found, name, x, radius)
        assert contact_moments(found, name) + springs == pytest.approx(0.0, abs=20.0)  # of 5 to 19 kN m, dry


@pytest.mark.parametrize("name", [WAGON, "vehicle_curve"])
def test_what_hauls_the_vehicle_is_the_heat_of_creep(name: str | Path) -> None:
    """Per metre of line a wheelset moves by 1 m along and turns by 1/R: -(F_x + M_z / R) of all is the sum of Tγ."""
    radius = 300.0
    found = steady(of(name, 0.1), radius, 0.06)
    wheelsets = [str(body) for body in found["body"].to_numpy() if str(body).startswith("wheelset")]
    turning = sum(contact_moments(found, wheelset) for wheelset in wheelsets) / radius
    hauled = -(float(found["longitudinal_force"].sum()) + turning)
    assert hauled == pytest.approx(float(found["wear_number"].sum()), rel=5e-3)


@pytest.mark.parametrize("friction", [0.3, 0.1])
def test_tight_curve_dry_and_lubricated(friction: float) -> None:
    """The leading wheelset runs at an angle of about the wheelbase over the radius, and its inner wheel slides outwards."""
    found = rr.curving(of("vehicle_curve", friction), [300.0], [0.0, 0.1], cant=CANT).isel(radius=0)
    assert (found["failure"] == "").all()
    assert float(found["unbalanced_force"].max()) < 1e-3
    leading, trailing = found["angle_of_attack"].isel(wheelset=0), found["angle_of_attack"].isel(wheelset=1)
    np.testing.assert_allclose(leading - trailing, 2.56 / 300.0, rtol=0.1)  # primary springs give way
    inner = found["derailment_quotient"].sel(wheel="wheelset_1_left")
    assert ((inner > 0.75 * friction) & (inner < 1.1 * friction)).all()  # the tread's inclination adds 0.008
    outer = found["guiding_force"].sel(wheel="wheelset_1_right")
    assert (outer > found["guiding_force"].drop_sel(wheel="wheelset_1_right").max("wheel")).all()


def test_lubrication_lowers_guiding_forces_and_wear() -> None:
    dry, lubricated = (rr.curving(of("vehicle_curve", mu), [300.0], [0.06], cant=CANT) for mu in (0.3, 0.1))
    for name in ("guiding_force", "wear_number"):
        assert float(lubricated[name].max()) < 0.65 * float(dry[name].max())


@pytest.mark.slow
def test_a_run_in_a_long_curve_ends_in_the_steady_state() -> None:
    case, radius = of(WAGON), 500.0
    found = rr.curving(case, [radius], [0.06], cant=CANT).isel(radius=0, cant_deficiency=0)
    assert float(found["growth_rate"]) < -0.5  # what is left after the transition decays
    line = [
        {"kind": "straight", "length": 20.0},
        {"kind": "transition", "length": 60.0},
        {"kind": "curve", "length": 400.0, "radius": radius, "cant": CANT},
    ]
    motion = {"motion.speed_mps": float(found["speed"]), "time.duration": "16 s", "time.output_step": "20 ms"}
    method = {"time.method": "exponential_adams", "time.step": "1 ms"}
    run = rr.simulate(curving_case(case).with_changes({"support.segment": line, **motion, **method}))
    end = rr.wheel_forces(run).isel(time=-1)
    for name in ("guiding_force", "wheel_load", "wear_number"):
        np.testing.assert_allclose(end[name], found[name], rtol=2e-4)
    yaw = run["yaw"].isel(time=-1).sel(body=found["wheelset"].to_numpy())
    np.testing.assert_allclose(-yaw, found["angle_of_attack"], rtol=1e-4)


def test_a_curve_to_the_right_is_the_mirror_image() -> None:
    left, right = (
        rr.curving(of("vehicle_curve"), [400.0, 800.0], [0.06], cant=CANT, direction=way) for way in ("left", "right")
    )
    for name in ("guiding_force", "wheel_load", "contact_angle", "wear_number"):
        swapped = right[name].to_numpy().reshape(2, 4, 2)[:, :, ::-1].reshape(2, 1, 8)
        np.testing.assert_allclose(left[name], swapped, rtol=1e-6)
    for name in ("angle_of_attack", "lateral", "guiding_force_sum", "speed"):
        np.testing.assert_allclose(left[name], right[name], rtol=1e-6)


def test_the_straight_is_the_limit_of_large_radii() -> None:
    """At one speed and without cant: a curve ten times as wide is ten times as near to the straight."""
    case = of("vehicle_curve")
    straight = equilibrium_dataset(assemble(curving_case(case).with_changes({"motion.speed": "30 m/s"}))).isel(time=0)
    away = []
    for radius in (1e5, 1e6):
        found = rr.curving(case, [radius], [30.0**2 / radius * BASE / G], cant=0.0).isel(radius=0, cant_deficiency=0)
        assert float(found["speed"]) == pytest.approx(30.0)
        away.append(
            [float(abs(found["wheel_load"] - straight["vertical_force"]).max()), float(abs(found["lateral"]).max())]
        )
    np.testing.assert_allclose(away[1], np.array(away[0]) / 10.0, rtol=0.05)
    assert away[1][0] < 20.0


@pytest.mark.slow
def test_what_no_vehicle_does_is_named() -> None:
    found = rr.curving(of(WAGON), [500.0], [-0.12, 0.0, 0.7, 1.2], cant=0.1).isel(radius=0)
    slow, fine, lifted, refused = (str(why) for why in found["failure"].to_numpy())
    assert "no speed between 1 and 200 m/s" in slow
    assert fine == ""
    assert lifted.startswith("wheelset_1_left lifts: ")
    assert "speed beyond overturning" in refused
    assert np.isnan(found["wheel_load"].isel(cant_deficiency=[0, 2, 3])).all()
    assert np.isfinite(found["wheel_load"].isel(cant_deficiency=1)).all()


def test_a_locomotive_given_as_a_bogie_on_rollers_runs_as_a_whole_on_rails() -> None:
    case = of("locomotive_traction")
    found = rr.curving(case, [1000.0], [0.06]).isel(radius=0, cant_deficiency=0)
    assert (found["failure"] == "").all()
    assert found.sizes["wheelset"] == 4
    phi = math.asin(0.1 / BASE)
    normal = G * math.cos(phi) + float(found["speed"]) ** 2 / 1000.0 * math.sin(phi)
    assert float(found["wheel_load"].sum()) == pytest.approx(86e3 * normal, rel=1e-3)
