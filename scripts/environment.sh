# Sourced by the other scripts: checks the machine and puts rollerrig into .venv, built from this folder.
#
#   in    Python >= 3.11 with venv and headers, a C++20 compiler; nothing else is asked of the machine
#   out   $venv (the environment), $jobs (parallel compile jobs), a working `rollerrig` in $venv/bin
#
# Everything else (CMake, Ninja, Eigen, nanobind, the Python libraries) comes from PyPI as wheels.
# Running again is cheap: what is installed stays, and only changed C++ files are compiled again.
#
# Variables a user may set:
#   PYTHON   the interpreter to use            (default: the newest of python3.14 ... python3.11, python3)
#   VENV     where the environment lies        (default: .venv)
#   JOBS     parallel compile jobs             (default: the cores, as far as there are 1.5 GB of memory for each)

set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
cd "$root"
venv="${VENV:-$root/.venv}"

default_jobs() {
  local cores gigabytes
  cores="$(getconf _NPROCESSORS_ONLN 2>/dev/null || echo 2)"
  gigabytes="$(awk '/MemAvailable/ { print int($2 / 1572864) }' /proc/meminfo 2>/dev/null)"
  if [[ -n "$gigabytes" && "$gigabytes" -lt "$cores" ]]; then cores="$gigabytes"; fi
  if [[ "$cores" -lt 1 ]]; then cores=1; fi
  echo "$cores"
}
jobs="${JOBS:-$(default_jobs)}"
export CMAKE_BUILD_PARALLEL_LEVEL="$jobs"
export PIP_DISABLE_PIP_VERSION_CHECK=1

say() { printf '\n== %s\n' "$*"; }
fail() {
  printf '\nerror: %s\n' "$1" >&2
  shift
  for line in "$@"; do printf '       %s\n' "$line" >&2; done
  exit 2
}

python_is_new_enough() { "$1" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; }

find_python() {
  local name names=(python3.14 python3.13 python3.12 python3.11 python3)
  if [[ -n "${PYTHON:-}" ]]; then names=("$PYTHON"); fi
  for name in "${names[@]}"; do
    if command -v "$name" >/dev/null && python_is_new_enough "$name" && python_has_what_is_needed "$name"; then
      command -v "$name"
      return
    fi
  done
  for name in "${names[@]}"; do
    if command -v "$name" >/dev/null && python_is_new_enough "$name"; then
      fail "$name lacks venv, pip or its C headers (Python.h), which building the extension needs" \
        "Debian, Ubuntu:  sudo apt-get install python3-venv python3-dev" \
        "Fedora:          sudo dnf install python3-devel"
    fi
  done
  fail "Python 3.11 or newer was not found; looked for ${names[*]}" \
    "Install it, or name one:  PYTHON=/path/to/python3.12 $0"
}

python_has_what_is_needed() {
  "$1" - 2>/dev/null <<'PYTHON_CODE'
import ensurepip, pathlib, sysconfig, venv
raise SystemExit(not pathlib.Path(sysconfig.get_path("include"), "Python.h").is_file())
PYTHON_CODE
}

check_compiler() {
  local compiler="${CXX:-}"
  if [[ -z "$compiler" ]]; then
    for compiler in c++ g++ clang++ ""; do
      [[ -n "$compiler" ]] && command -v "$compiler" >/dev/null && break
    done
  fi
  [[ -n "$compiler" ]] || fail "no C++ compiler was found" \
    "Debian, Ubuntu:  sudo apt-get install g++" \
    "Fedora:          sudo dnf install gcc-c++" \
    "or name one:     CXX=/path/to/g++ $0"
  local probe
  probe="$(mktemp -d)"
  if ! printf '#include <concepts>\n#include <numbers>\nstruct S { double a, b; };\ntemplate <std::floating_point T> T f(T x) { auto [a, b] = S{x, x}; return [&] { return a + b; }(); }\nint main() { return f(0.0) > std::numbers::pi; }\n' |
    "$compiler" -std=c++20 -x c++ - -o "$probe/program" >"$probe/log" 2>&1; then
    cat "$probe/log" >&2
    rm -rf "$probe"
    fail "$compiler cannot compile C++20; GCC 11 or Clang 16 and newer can"
  fi
  rm -rf "$probe"
  CXX="$(command -v "$compiler")"
  export CXX  # else the build would look for the compiler that Python itself was built with
}

# install EXTRAS...: rollerrig with these optional groups of pyproject.toml.
install() {
  check_compiler
  if [[ ! -x "$venv/bin/python" ]] || ! python_is_new_enough "$venv/bin/python"; then
    local python
    python="$(find_python)"
    say "creating the environment $venv with $("$python" --version)"
    "$python" -m venv --clear "$venv" || fail "the environment $venv could not be created"
  fi
  mkdir -p build
  local log="$root/build/install.log" extras
  extras="$(IFS=,; echo "$*")"

  # The build tools live in the environment too: a build whose paths stay the same compiles only what changed.
  local tools=("scikit-build-core>=1.0" "nanobind>=3.0" "cmeel-eigen>=3.4" "cmake>=3.20" "ninja>=1.11")
  say "installing rollerrig${extras:+ with $extras}: the first time it downloads and compiles for some minutes"
  printf '   (details: %s)\n' "$log"
  if ! {
    "$venv/bin/python" -m pip install "${tools[@]}" &&
      PATH="$venv/bin:$PATH" "$venv/bin/python" -m pip install --no-build-isolation ".${extras:+[$extras]}"
  } >"$log" 2>&1; then
    tail -n 40 "$log" >&2
    rm -rf build/cp3*  # a half-configured build would remember what was missing
    fail "the installation failed; the whole log is in $log"
  fi
}
