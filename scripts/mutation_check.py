"""Do the tests notice a wrong formula? Each mutant is a small mistake in the core; the tests named with it must fail.

    python scripts/mutation_check.py [--only TEXT] [--jobs N]

The core is built once; for each mutant one text is replaced in a copy of the sources, and the tests named with it are compiled
with it, linked with that core and run. A mutant that no test notices has survived: write the test. Long (some minutes), not part
of the suite.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
TREE = ROOT / "build" / "mutation"
FOLDERS = ("core", "tests", "third_party", "cmake")


class Mutant(NamedTuple):
    """A mistake.

    Attributes:
        what: in words.
        file: below core/.
        right: text that stands there exactly once.
        wrong: in its place.
        tests: files below tests/core that must notice it.
    """

    what: str
    file: str
    right: str
    wrong: str
    tests: tuple[str, ...]


MUTANTS = (
    Mutant("stiffness of Hertz (13) grows with the curvatures", "include/rollerrig/contact/normal/hertz.hpp",
           "(material.compliance() * root_sum);  // (13)",
           "(material.compliance()) * root_sum;  // (13)", ("contact/test_hertz.cpp",)),
    Mutant("axis ratio (16): a sign", "src/contact/tables.cpp",
           "(k - e) / (e / g2 - k)",
           "(k - e) / (e / g2 + k)", ("contact/test_hertz.cpp",)),
    Mutant("semi-axes (17) exchanged", "include/rollerrig/contact/normal/hertz.hpp",
           "contact.b_per_root = table.semi_axis.at(-x)",
           "contact.b_per_root = table.semi_axis.at(x)", ("contact/test_hertz.cpp",)),
    Mutant("Kalker's table: interpolation in Poisson's ratio", 'src/contact/tables.cpp',
           'double const w1 = -16.0 *',
           'double const w1 = -8.0 *', ("contact/test_kalker.cpp",)),
    Mutant("C23 of (22) keeps its sign when rolling backward", "include/rollerrig/contact/creep/creep_query.hpp",
           "c.c23 * direction",
           "c.c23", ("contact/test_creep_laws.cpp",)),
    Mutant("lateral force of spin in (20): a sign", "include/rollerrig/contact/creep/creep_query.hpp",
           "-(f.f22 * e.lateral) - f.f23 * e.spin",
           "-(f.f22 * e.lateral) + f.f23 * e.spin", ("contact/test_creep_law.cpp",)),
    Mutant("saturation (23): a factor", "include/rollerrig/contact/creep/creep_query.hpp",
           "tau * tau / 27.0",
           "tau * tau / 9.0", ("contact/test_creep_law.cpp",)),
    Mutant("Polach's force: the area of adhesion left out", 'include/rollerrig/contact/creep/polach.hpp',
           '(stick / (1.0 + stick * stick) + atan2(',
           '(atan2(', ("contact/test_creep_laws.cpp",)),
    Mutant("FASTSIM: the weight of spin", "include/rollerrig/contact/creep/fastsim.hpp",
           "T const kalker_across = 2.0 *",
           "T const kalker_across = 1.0 *", ("contact/test_creep_laws.cpp",)),
    Mutant("creepage (21) of spin not over the rolling speed", "include/rollerrig/contact/patch.hpp",
           "out.spin_rate * inverse_speed};",
           "out.spin_rate};", ("contact/test_patch.cpp",)),
    Mutant("velocity of the wheel in (12), (21) not relative to the roller", "include/rollerrig/contact/patch.hpp",
           "Vec3<T> const v = v_on_wheel - v_on_roller;",
           "Vec3<T> const v = v_on_wheel;", ("contact/test_patch.cpp",)),
    Mutant("spin (21) of wheel and roller: a sign", "include/rollerrig/contact/patch.hpp",
           "motion.omega_wheel - motion.omega_roller;",
           "motion.omega_wheel + motion.omega_roller;", ("contact/test_patch.cpp",)),
    Mutant("normal damper (12): a factor", "include/rollerrig/contact/normal/normal_patch.hpp",
           "return 0.5 * damping *",
           "return damping *", ("contact/test_normal_force.cpp",)),
    Mutant("a separating wheel is pulled back", "include/rollerrig/contact/normal/normal_patch.hpp",
           "select(elastic + damping > 0.0, damping, -elastic)",
           "damping", ("contact/test_normal_force.cpp",)),
    Mutant("blending weight (F4): not smooth at the fold", "include/rollerrig/contact/normal/hertz_ellipses.hpp",
           "select(t < 1.0, t * t * (3.0 - 2.0 * t), T(1.0))",
           "select(t < 1.0, T(1.0), T(1.0))", ("contact/test_patch.cpp",)),
    Mutant("strips (S3): compliance of one body", "src/contact/normal/strip_contact.cpp",
           "set_lane(pack.compliance, i, wheel.wheel->material.compliance() / pi);",
           "set_lane(pack.compliance, i, 0.5 * wheel.wheel->material.compliance() / pi);", ("contact/test_strips.cpp",)),
    Mutant("falling friction (A1): A left out", "include/rollerrig/contact/adhesion/friction.hpp",
           "((1.0 - A) * exp(-B * slip) + A)",
           "((1.0 - A) * exp(-B * slip))", ("mechatronics/test_actuators.cpp",)),
    Mutant("adhesion recovery (A2): degraded and recovered exchanged", "include/rollerrig/contact/adhesion/friction.hpp",
           "blended(recovered.at(slip), degraded.at(slip),",
           "blended(degraded.at(slip), recovered.at(slip),", ("mechatronics/test_actuators.cpp",)),
    Mutant("gyroscopic moment left out of Euler's equations", 'include/rollerrig/multibody/body.hpp',
           'return cross(m.frame_body, Vec3<T>{I.x * w.x, I.y * w.y, I.z * w.z});',
           'return T(0.0) * cross(m.frame_body, Vec3<T>{I.x * w.x, I.y * w.y, I.z * w.z});', ("multibody/test_body.cpp",)),
    Mutant("Coriolis acceleration of the moving frame (W4): a factor", "include/rollerrig/multibody/moving_frame.hpp",
           "T(2.0) * m.v)",
           "T(1.0) * m.v)", ("track/test_moving_frame.cpp",)),
    Mutant("Euler acceleration of the moving frame (W4): a sign", "include/rollerrig/multibody/moving_frame.hpp",
           "frame.a + cross(frame.alpha, place)",
           "frame.a - cross(frame.alpha, place)", ("track/test_moving_frame.cpp",)),
    Mutant("Maxwell branch: the inner node runs with stiffness", "include/rollerrig/multibody/force_laws.hpp",
           "branch / damping",
           "branch / series_stiffness", ("multibody/test_force_element.cpp",)),
    Mutant("clamped element: no moment of its stretch", "include/rollerrig/multibody/force_element.hpp",
           "Vec3<T> const slip = v_b - v_a - cross(b.frame_omega - a.frame_omega, m.stretch);",
           "Vec3<T> const slip = v_b - v_a;", ("multibody/test_force_element.cpp",)),
    Mutant("classical Runge-Kutta: a weight", "include/rollerrig/integrate/exponential_runge_kutta_4.hpp",
           "(k1_ + 2 * k2_ + 2 * k3_ + k4_)",
           "(k1_ + 2 * k2_ + k3_ + 2 * k4_)", ("integrate/test_order_of_accuracy.cpp",)),
    Mutant("RODAS4: a coefficient of the right-hand side", "include/rollerrig/integrate/rodas4.hpp",
           "-9.594562251023355",
           "-9.594562261023355", ("integrate/test_rodas4.cpp",)),
    Mutant("stiff modes: phi_2 of the exponential method", "include/rollerrig/integrate/exponential_runge_kutta_4.hpp",
           "phi2 = 0.5 + z * phi3;",
           "phi2 = 0.5 + 2.0 * z * phi3;", ("integrate/test_exponential.cpp",)),
    Mutant("brake torque with the turning", "include/rollerrig/mechatronics/brakes.hpp",
           "return -(sliding_torque(",
           "return (sliding_torque(", ("mechatronics/test_pneumatics.cpp",)),
    Mutant("WSP: vents below its threshold of slip", "include/rollerrig/mechatronics/wheel_slide_protection.hpp",
           "((slip > vent_above || locks_up)",
           "((slip < vent_above || locks_up)", ("mechatronics/test_actuators.cpp",)),
    Mutant("observer: its gain of the force", "include/rollerrig/mechatronics/estimators.hpp",
           "s.force += l2 * error",
           "s.force += l1 * error", ("mechatronics/test_estimators.cpp",)),
    Mutant("virtual train: forces over half of its mass", "include/rollerrig/mechatronics/virtual_train.hpp",
           "- retarding) / train.mass -",
           "- retarding) / (0.5 * train.mass) -", ("mechatronics/test_rig_control.cpp",)),
    Mutant("feed-forward (D5): a sign", "src/mechatronics/rig_controller.cpp",
           "wheels.rate -",
           "wheels.rate +", ("mechatronics/test_rig_control.cpp",)),
)  # fmt: skip


def main() -> int:
    """Build and try every mutant; 1 if one survived."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="only mutants with this text in their description")
    parser.add_argument("--jobs", type=int, default=2, help="compilers at a time")
    asked = parser.parse_args()
    chosen = [mutant for mutant in MUTANTS if asked.only in mutant.what]
    copy_sources(sorted({test for mutant in MUTANTS for test in mutant.tests}))
    configure()
    if not built(("core",), asked.jobs):
        return 2
    for test in sorted({test for mutant in chosen for test in mutant.tests}):
        if not built((program(test),), asked.jobs) or not passed(test):
            print(f"{test} fails without any mutant: nothing to be learnt from it")
            return 2
    survivors = []
    for mutant in chosen:
        begun = time.monotonic()
        killed = tried(mutant, asked.jobs)
        print(f"{'killed  ' if killed else 'SURVIVED'} {time.monotonic() - begun:5.0f} s  {mutant.what}", flush=True)
        survivors += [] if killed else [mutant.what]
    print(f"{len(chosen) - len(survivors)} of {len(chosen)} mutants killed")
    return 1 if survivors else 0


def copy_sources(tests: list[str]) -> None:
    """The sources, with one program per test file; what is unchanged keeps its date and is not built again."""
    for folder in FOLDERS:
        for old in (TREE / folder).rglob("*"):
            if old.is_file() and not (ROOT / old.relative_to(TREE)).is_file():
                old.unlink()
        for source in (ROOT / folder).rglob("*"):
            target = TREE / source.relative_to(ROOT)
            if source.is_file() and source.suffix in (".hpp", ".h", ".cpp", ".cmake"):
                write(target, source.read_bytes())
    programs = ""
    for test in tests:
        mutated = {m.file for m in MUTANTS if test in m.tests and m.file.startswith("src/")}
        sources = " ".join(f"core/{source}" for source in sorted(mutated))
        programs += f"""
add_executable({program(test)} EXCLUDE_FROM_ALL tests/core/main.cpp tests/core/{test} {sources})
target_include_directories({program(test)} PRIVATE core/include tests tests/core)
target_include_directories({program(test)} SYSTEM PRIVATE third_party)
target_link_libraries({program(test)} PRIVATE $<TARGET_FILE:core> Eigen3::Eigen)
"""
    text = f"""cmake_minimum_required(VERSION 3.20)
project(mutants LANGUAGES CXX)
set(CMAKE_CXX_STANDARD 20)
include(cmake/eigen.cmake)
file(GLOB_RECURSE sources CONFIGURE_DEPENDS core/src/*.cpp)
add_library(core STATIC ${{sources}})
target_include_directories(core PUBLIC core/include)
target_link_libraries(core PUBLIC Eigen3::Eigen)
{programs}"""
    write(TREE / "CMakeLists.txt", text.encode())


def write(target: Path, content: bytes) -> None:
    """Write a file where it differs."""
    if not target.is_file() or target.read_bytes() != content:
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(content)


def program(test: str) -> str:
    """Name of the program of a test file."""
    return test.removesuffix(".cpp").replace("/", "_")


def configure() -> None:
    """Unoptimised: compiling costs more than running."""
    launcher = ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
    options = ["-G", "Ninja", "-DCMAKE_BUILD_TYPE=None", "-DCMAKE_CXX_FLAGS=-O1", *launcher]
    subprocess.run(["cmake", "-S", TREE, "-B", TREE / "build", *options], check=True, stdout=subprocess.DEVNULL)


def built(names: tuple[str, ...], jobs: int) -> bool:
    """Whether the core, or programs of tests, can be built."""
    targets = [part for name in names for part in ("--target", name)]
    command = ["cmake", "--build", TREE / "build", *targets, "-j", str(jobs)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        print(done.stdout[-2000:])
    return done.returncode == 0


def passed(test: str) -> bool:
    """Whether the tests of a file pass."""
    command = [TREE / "build" / program(test), "--abort-after=1"]
    return subprocess.run(command, capture_output=True, check=False, timeout=300).returncode == 0


def tried(mutant: Mutant, jobs: int) -> bool:
    """Whether a test notices the mutant."""
    path = TREE / "core" / mutant.file
    original = path.read_text()
    if original.count(mutant.right) != 1:
        raise SystemExit(f"{mutant.what}: {mutant.file} has {mutant.right!r} {original.count(mutant.right)} times")
    try:
        path.write_text(original.replace(mutant.right, mutant.wrong))
        if not built(tuple(map(program, mutant.tests)), jobs):
            raise SystemExit(f"{mutant.what}: does not compile")
        return not all(passed(test) for test in mutant.tests)
    finally:
        path.write_text(original)


if __name__ == "__main__":
    sys.exit(main())
