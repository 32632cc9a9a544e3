"""The frames in Python against the C header: the same bytes both ways."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from rollerrig.interfaces.realtime import c_header
from rollerrig.interfaces.realtime.frames import ASK, COMMAND, DESCRIPTION, REARM, SENSORS, Frame, pack, unpack

PROGRAM = """
#include <stdio.h>
#include "rollerrig_wire.h"
/* reads a frame from the standard input, prints its fields, and writes it anew to the file that is named */
int main(int argc, char** argv) {
  unsigned char in[RR_LARGEST_FRAME + 1], out[RR_LARGEST_FRAME];
  double values[RR_MOST_VALUES];
  rr_header header;
  size_t const size = fread(in, 1, sizeof in, stdin);
  int const outcome = rr_read(in, size, &header, values, RR_MOST_VALUES);
  FILE* file;
  unsigned i;
  (void)argc;
  printf("%d\\n", outcome);
  if (outcome != RR_OK) return 0;
  printf("%d %d %u %u %lld %u %d %d\\n", header.kind, header.flags, (unsigned)header.session, (unsigned)header.sequence,
         (long long)header.time_ns, (unsigned)header.answers, header.count, header.state);
  for (i = 0; i < header.count; ++i) printf("%.17g\\n", values[i]);
  file = fopen(argv[1], "wb");
  fwrite(out, 1, rr_write(&header, values, out, sizeof out), file);
  return fclose(file);
}
"""

FRAME = Frame(COMMAND, REARM, 4_000_000_000, 2**32 - 1, -5_000_000_007, 17, 0, (1.5, -0.0, 1e-308, 2.0**60))


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        pytest.skip("no C compiler")
    folder = tmp_path_factory.mktemp("wire")
    (folder / "echo.c").write_text(PROGRAM)
    warnings = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]
    command = [compiler, *warnings, f"-I{c_header().parent}", "-o", str(folder / "echo"), str(folder / "echo.c")]
    subprocess.run(command, check=True)
    return folder / "echo"


def echoed(program: Path, data: bytes) -> tuple[list[str], bytes]:
    out = program.with_name("out.bin")
    out.unlink(missing_ok=True)
    done = subprocess.run([program, out], input=data, capture_output=True, check=True)
    return done.stdout.decode().split("\n"), out.read_bytes() if out.exists() else b""


@pytest.mark.parametrize(
    "frame", [FRAME, Frame(ASK, answers=3), Frame(SENSORS, values=tuple(np.arange(512.0)), state=2)]
)
def test_c_reads_what_python_writes_and_the_other_way_round(program: Path, frame: Frame) -> None:
    data = pack(frame)
    lines, back = echoed(program, data)
    assert lines[0] == "0"
    fields = (frame.kind, frame.flags, frame.session, frame.sequence, frame.time_ns, frame.answers, len(frame.values))
    assert lines[1] == " ".join(map(str, (*fields, frame.state)))
    assert [float(line) for line in lines[2 : 2 + len(frame.values)]] == list(frame.values)
    assert back == data
    assert unpack(back) == frame


def test_both_refuse_the_same_frames(program: Path) -> None:
    good = pack(FRAME)
    outcomes = {
        "1": good[:20],
        "2": b"X" + good[1:],
        "3": good[:4] + b"\2" + good[5:],
        "4": good[:40] + b"!" + good[41:],
    }
    for outcome, data in outcomes.items():
        assert unpack(data) is None
        assert echoed(program, data)[0][0] == outcome


def test_every_changed_byte_is_noticed() -> None:
    good = pack(FRAME)
    for i in range(len(good)):
        assert unpack(good[:i] + bytes([good[i] ^ 1]) + good[i + 1 :]) is None
        assert unpack(good[:i]) is None


def test_a_part_of_the_description_holds_bytes() -> None:
    part = Frame(DESCRIPTION, session=9, sequence=1, answers=2, text="µm".encode())
    assert unpack(pack(part)) == part
