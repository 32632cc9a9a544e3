"""Sessions of FMI 2.0 and 3.0 in any order, on the library of an exported FMU: each call is answered with a status.

Pointers to numbers are null or have room for as many as are said; a handle may be freed, null, or none of the library. Saved
states are also changed and their checksums made right: bytes 8 to 15 are that of what follows the head.
"""

from __future__ import annotations

import ctypes
import random
import struct
import tempfile
import zipfile
from pathlib import Path
from typing import Any

import rollerrig as rr
from hostile.bytes_of import NUMBERS, crc64, spoiled
from rollerrig.interfaces.fmu.export import export_part

REFUSALS = ()
HEAD = 96
CALLS = 25
Handle = ctypes.c_void_p
Log2 = ctypes.CFUNCTYPE(None, Handle, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p)
Log3 = ctypes.CFUNCTYPE(None, Handle, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p)


class Callbacks(ctypes.Structure):
    """fmi2CallbackFunctions."""

    _fields_ = [(name, Handle) for name in ("logger", "allocate", "free", "finished", "environment")]


class Fmu:
    """An exported FMU, unpacked and loaded."""

    def __init__(self, case: str, fmi: str, kind: str, part: str | None) -> None:
        folder = Path(tempfile.mkdtemp(prefix="hostile"))
        if part:
            export_part(case, part, folder / "x.fmu", fmi=fmi)
        else:
            rr.export_fmu(case, folder / "x.fmu", fmi=fmi, kind=kind)
        with zipfile.ZipFile(folder / "x.fmu") as archive:
            archive.extractall(folder)
        text = (folder / "modelDescription.xml").read_text()
        mark = "guid" if fmi == "2" else "instantiationToken"
        self.token = text.split(f'{mark}="')[1].split('"')[0].encode()
        self.resources = folder / "resources"
        self.fmi, self.exchange = fmi, kind != "cs"
        self.library = ctypes.CDLL(str(next((folder / "binaries").glob("*linux*/*.so"))))
        self.log2, self.log3 = Log2(lambda *_: None), Log3(lambda *_: None)
        self.callbacks = Callbacks(ctypes.cast(self.log2, Handle))
        self.references = text.count("<ScalarVariable ") + text.count("<Float64 ") + 5

    def instantiate(self, exchange: bool, token: bytes) -> int | None:
        if self.fmi == "2":
            call = self.function("fmi2Instantiate", Handle)
            uri = self.resources.as_uri().encode()
            return call(b"x", int(exchange), token, uri, ctypes.byref(self.callbacks), 0, 0)
        where, log = str(self.resources).encode(), ctypes.cast(self.log3, Handle)
        if exchange:
            return self.function("fmi3InstantiateModelExchange", Handle)(b"x", token, where, False, False, None, log)
        create = self.function("fmi3InstantiateCoSimulation", Handle)
        return create(b"x", token, where, False, False, False, False, None, ctypes.c_size_t(0), None, log, None)

    def function(self, name: str, result: Any = ctypes.c_int) -> Any:
        found = getattr(self.library, name)
        found.restype = result
        return found


KINDS = (
    ("adhesion_brake", "both", None),
    ("wheelset_rollers", "both", None),
    ("adhesion_brake", "cs", "slide_protection"),
)


def prepare() -> list[Fmu]:
    return [Fmu(case, fmi, kind, part) for fmi in "23" for case, kind, part in KINDS]


def attack(fmus: list[Fmu], choose: random.Random) -> str:
    fmu = choose.choice(fmus)
    session = Session(fmu, choose)
    for _ in range(CALLS):
        session.step()
    session.end()
    return "ran" if session.good > 2 else "refused"


class Session:
    """Instances and saved states of one FMU, and calls on them."""

    def __init__(self, fmu: Fmu, choose: random.Random) -> None:
        self.fmu, self.choose, self.good = fmu, choose, 0
        self.live: list[int] = []
        self.ended: list[int] = [0, id(self) & ~7]
        self.states: list[int] = [0, 8]
        self.time = 0.0
        self.begin()
        if choose.random() < 0.8:  # most sessions begin as they should
            self.initialize()

    def handle(self) -> Handle:
        foreign = not self.live or self.choose.random() < 0.05
        return Handle(self.choose.choice(self.ended if foreign else self.live))

    def call(self, name: str, *given: Any) -> int:
        status = self.fmu.function(f"fmi{self.fmu.fmi}{name}")(self.handle(), *given)
        if not 0 <= status <= 3:
            raise AssertionError(f"{name} is answered with {status}")
        self.good += status == 0
        return status

    def begin(self) -> None:
        token = self.fmu.token if self.choose.random() < 0.95 else b"another"
        made = self.fmu.instantiate(self.fmu.exchange and self.choose.random() < 0.5, token)
        if made:
            self.live.append(made)
            self.time = 0.0

    def free(self) -> None:
        handle = self.handle()
        self.fmu.function(f"fmi{self.fmu.fmi}FreeInstance", None)(handle)
        if handle.value in self.live:
            self.live.remove(handle.value)
            self.ended.append(handle.value)
            self.states = [0, 8]

    def number(self) -> float:
        return self.choose.choice([0.0, 0.001, 0.01, 1.0, *NUMBERS])

    def initialize(self) -> None:
        start, stop = self.choose.choice([(0.0, 1.0)] * 8 + [(self.number(), self.number())])
        timing = (ctypes.c_double(start), 0, ctypes.c_double(stop))
        if self.fmu.fmi == "2":
            self.call("SetupExperiment", 0, ctypes.c_double(0.0), *timing)
            self.call("EnterInitializationMode")
        else:
            self.call("EnterInitializationMode", False, ctypes.c_double(0.0), *timing)
        if self.choose.random() < 0.9:
            self.call("ExitInitializationMode")

    def values(self) -> tuple[Any, int, Any]:
        count = self.choose.choice([0, 1, 1, 3, 50])
        references = (ctypes.c_uint * max(1, count))(
            *(self.choose.choice([self.choose.randrange(self.fmu.references), 2**32 - 1, 0]) for _ in range(count))
        )
        numbers = (ctypes.c_double * max(1, count))(*(self.number() for _ in range(count)))
        null = self.choose.random() < 0.03
        return (None if null else references), count, numbers

    def get_or_set(self) -> None:
        references, count, numbers = self.values()
        size = ctypes.c_size_t(count)
        more = [] if self.fmu.fmi == "2" else [size]
        name = self.choose.choice(["Get", "Get", "Set"]) + ("Real" if self.fmu.fmi == "2" else "Float64")
        self.call(name, references, size, numbers, *more)

    def do_step(self) -> None:
        length = self.choose.choice([0.001, 0.001, 0.005, 0.01, 0.0, -1.0, 1e-300, 1e300, float("nan")])
        at = self.time if self.choose.random() < 0.95 else self.number()
        given = [ctypes.c_double(at), ctypes.c_double(length), 0]
        if self.fmu.fmi == "3":
            given += [ctypes.byref(ctypes.c_bool()) for _ in range(3)] + [ctypes.byref(ctypes.c_double())]
        if self.call("DoStep", *given) == 0:
            self.time = at + length

    def exchange(self) -> None:
        room = (ctypes.c_double * 400)(*(self.number() for _ in range(400)) if self.choose.random() < 0.1 else ())
        size = ctypes.c_size_t(self.choose.choice([0, 1, 19, 31, 32, 33, 34, 400]))
        flags = [ctypes.byref(ctypes.c_int()) for _ in range(5)]
        derivatives = "GetDerivatives" if self.fmu.fmi == "2" else "GetContinuousStateDerivatives"
        match self.choose.randrange(6):
            case 0:
                self.call(self.choose.choice(["EnterEventMode", "EnterContinuousTimeMode"]))
            case 1:
                self.call("SetTime", ctypes.c_double(self.number()))
            case 2:
                self.call("SetContinuousStates", room, size)
            case 3:
                self.call(self.choose.choice(["GetContinuousStates", derivatives, "GetEventIndicators"]), room, size)
            case 4:
                self.call("CompletedIntegratorStep", 0, *flags[:2])
            case 5:
                known, many, seeds = self.values()
                unknown, count, out = self.values()
                given = [unknown, ctypes.c_size_t(count), known, ctypes.c_size_t(many), seeds]
                given += [out] if self.fmu.fmi == "2" else [ctypes.c_size_t(many), out, ctypes.c_size_t(count)]
                self.call("GetDirectionalDerivative", *given)

    def saved(self) -> None:
        word = "FMUstate" if self.fmu.fmi == "2" else "FMUState"
        state = Handle(self.choose.choice(self.states))
        match self.choose.choice(["get", "get", "set", "set", "free", "bytes", "bytes", "bytes"]):
            case "get":
                if self.call(f"Get{word}", ctypes.byref(state)) == 0 and state.value:
                    self.states.append(state.value)
            case "set":
                self.call(f"Set{word}", state)
            case "free":
                self.call(f"Free{word}", ctypes.byref(state))
            case "bytes":
                self.from_bytes(word, state)

    def from_bytes(self, word: str, state: Handle) -> None:
        size = ctypes.c_size_t(0)
        serialized = f"Serialized{word}Size"
        if self.call(serialized, state, ctypes.byref(size)) != 0 or size.value < HEAD:
            return
        room = ctypes.create_string_buffer(size.value)
        self.call(f"Serialize{word}", state, room, size)
        content = checked(room.raw, self.choose)
        made = Handle(0)
        name = f"DeSerialize{word}" if self.fmu.fmi == "2" else f"Deserialize{word}"
        given = ctypes.create_string_buffer(content, len(content))
        if self.call(name, given, ctypes.c_size_t(len(content)), ctypes.byref(made)) == 0 and made.value:
            self.states.append(made.value)
            self.call(f"Set{word}", made)

    def step(self) -> None:
        """One call, most often one that fits."""
        deeds = [self.do_step] * 5 + [self.get_or_set] * 4 + [self.saved] * 4 + [self.free, self.begin, self.initialize]
        if self.fmu.exchange:
            deeds += [self.exchange] * 8
        if self.choose.random() < 0.03:
            self.call(self.choose.choice(["Terminate", "Reset"]))
        self.choose.choice(deeds)()

    def end(self) -> None:
        for handle in self.live:
            self.fmu.function(f"fmi{self.fmu.fmi}FreeInstance", None)(Handle(handle))


def checked(state: bytes, choose: random.Random) -> bytes:
    """A saved state, changed; its checksums right: the instance's, and that of the run inside it."""
    if choose.random() < 0.2:
        return spoiled(state, choose)
    head, body = bytearray(state[:HEAD]), state[HEAD:]
    skip = 8 * sum(struct.unpack("<QQ", bytes(head[24:40])))  # chosen numbers, states
    if choose.random() < 0.3:
        head = bytearray(spoiled(bytes(head), choose, 16).ljust(HEAD, b"\0")[:HEAD])
    if choose.random() < 0.7 and len(body) > skip + 24:
        known, run = body[skip : skip + 8], spoiled(body[skip + 16 :], choose)
        if len(run) >= 8:
            body = body[:skip] + known + struct.pack("<Q", crc64(run, struct.unpack("<Q", known)[0])) + run
    elif body and choose.random() < 0.5:
        body = spoiled(body, choose)
    if len(body) >= 8:
        head[8:16] = struct.pack("<Q", crc64(body))
    return bytes(head) + body
