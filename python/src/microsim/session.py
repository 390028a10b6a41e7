"""Session files: read by their documented format, every checksum compared.

The format stands in `crates/session/src/lib.rs` (frames), `crates/host/src/record.rs` (records), `crates/bus/src/frame.rs` (messages)
and `crates/message/src/` (what messages hold). Times are simulated seconds, lengths metres, forces newtons, orientations quaternions
x, y, z, w.

    with Session.open("NAME.session") as session:
        print(session.header["plan"]["module"], session.ending)
        for message in session.messages("tool.states"):
            ...

A file whose end is missing, as of a run that was killed, is read as far as it goes: `session.ending` states which it is once all was
read. What the signatures of stations prove is not checked here: `microsim replay SESSION --verify` does.
"""

from __future__ import annotations

import io
import os
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

from .attempt import Attempt
from .messagepack import NotMessagePack, unpack

MAGIC = b"MicroSim session\n"
FORMAT_VERSION = 1
# Formats of the records that this package reads.
RECORD_FORMATS = range(1, 5)

KIND_END, KIND_HEADER, KIND_TICK, KIND_CHECKPOINT, KIND_FAILURE, KIND_SIGNATURE, KIND_CLOSE = range(7)

_LARGEST = 1 << 26
_FRAME = struct.Struct("<IBQQI")
_MESSAGE = struct.Struct("<QQIHH")

# Names of the messages of the platform; modules bring others, which stand in the header of a session.
_CORE = (
    "contact.forces",
    "host.log",
    "host.progress",
    "input.end",
    "input.implausible",
    "input.sample",
    "level.control",
    "level.event",
    "level.state",
    "object.scene",
    "object.set",
    "picture.request",
    "session.record",
    "tissue.cut",
    "tissue.recovery",
    "tissue.solver",
    "tool.placements",
    "tool.sample",
    "tool.states",
    "training.result",
)


class NotASession(ValueError):
    """Bytes of which nothing can be read as a session."""


def kind_id(name: str) -> int:
    """Number by which a message of this name is known: 64-bit FNV-1a."""
    number = 0xCBF29CE484222325
    for byte in name.encode("utf-8"):
        number = ((number ^ byte) * 0x100000001B3) % (1 << 64)
    return number


@dataclass(frozen=True)
class Frame:
    """A record as the file has it, with right checksums."""

    offset: int
    kind: int
    sequence: int
    tick: int
    payload: bytes


@dataclass(frozen=True)
class Message:
    """What a plugin has published."""

    tick: int
    # Simulated time of the publication [s].
    time: float
    # Its name; `None` for one that neither the platform nor a plugin of this run has.
    kind: str | None
    # What it holds, with the names that it has in MicroSim.
    content: Any


@dataclass(frozen=True)
class Ending:
    """How the file ends: `clean` (closed), `open` (its process was killed between two records), `torn` (inside one) or `damaged`."""

    state: str
    # Where what cannot be read begins [byte]; `None` where all can.
    offset: int | None = None
    what: str | None = None

    @property
    def is_complete(self) -> bool:
        """Whether the session was closed, and every byte is as it was written."""
        return self.state == "clean"


class Session:
    """A session that is read record by record: what is in memory is one of them, however long it is."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        # How the file ends; `None` until it has been read to its end.
        self.ending: Ending | None = None
        begin = file.read(len(MAGIC) + 4)
        if not begin.startswith(MAGIC):
            raise NotASession("it does not begin as a session does")
        if len(begin) < len(MAGIC) + 4:
            raise NotASession("it ends before its first record")
        version = struct.unpack("<I", begin[len(MAGIC) :])[0]
        if version != FORMAT_VERSION:
            raise NotASession(f"format {version}; this package reads format {FORMAT_VERSION}")
        self._begin = len(begin)
        first = next(self.frames(), None)
        if first is None or first.kind != KIND_HEADER:
            what = self.ending.what if self.ending and self.ending.what else "another record comes first"
            raise NotASession(f"it has no header that can be read: {what}")
        # All that was known at the start: version, time, trainee, and the plan of the run.
        self.header: dict[str, Any] = _table(first.payload)
        if self.header.get("format") not in RECORD_FORMATS:
            raise NotASession(f"records of format {self.header.get('format')}; this package reads 1 to {RECORD_FORMATS[-1]}")
        self.ending = None
        names = set(_CORE)
        for plugin in self.plan["plugins"]:
            names.update(own["name"] for own in plugin["own_kinds"])
        self._names = {kind_id(name): name for name in names}

    @classmethod
    def open(cls, path: str | os.PathLike[str]) -> Session:
        """Opens a file; close it, or use `with`."""
        file = open(path, "rb")
        try:
            return cls(file)
        except BaseException:
            file.close()
            raise

    @classmethod
    def read(cls, data: bytes) -> Session:
        """A session in memory."""
        return cls(io.BytesIO(data))

    def close(self) -> None:
        """Closes the file."""
        self._file.close()

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def plan(self) -> dict[str, Any]:
        """What was loaded and computed."""
        plan: dict[str, Any] = self.header["plan"]
        return plan

    @property
    def tick_s(self) -> float:
        """Simulated time of a tick [s]."""
        return float(self.plan["tick_ns"]) * 1e-9

    def frames(self) -> Iterator[Frame]:
        """All records from the first on, up to the end of the file or what is wrong with it."""
        self._file.seek(self._begin)
        offset, expected, last = self._begin, 0, None
        while True:
            head = self._file.read(_FRAME.size + 4)
            if last == KIND_END:
                wrong = "bytes behind the record that closes it"
                self.ending = Ending("damaged", offset, wrong) if head else Ending("clean")
                return
            if not head:
                self.ending = Ending("open")
                return
            if len(head) < _FRAME.size + 4:
                self.ending = Ending("torn", offset, "it ends inside a record")
                return
            length, kind, sequence, tick, checksum = _FRAME.unpack_from(head)
            wrong = None
            if zlib.crc32(head[: _FRAME.size]) != struct.unpack_from("<I", head, _FRAME.size)[0]:
                wrong = "the checksum of a record's head does not fit"
            elif length > _LARGEST:
                wrong = f"a record of {length} bytes"
            elif sequence != expected:
                wrong = f"record {sequence} where record {expected} belongs"
            if wrong:
                self.ending = Ending("damaged", offset, wrong)
                return
            payload = self._file.read(length)
            if len(payload) < length:
                self.ending = Ending("torn", offset, "it ends inside a record")
                return
            if zlib.crc32(payload) != checksum:
                self.ending = Ending("damaged", offset, "the checksum of a record does not fit")
                return
            frame = Frame(offset, kind, sequence, tick, payload)
            offset += len(head) + length
            expected, last = expected + 1, kind
            # Where the caller reads something else meanwhile, this goes on where it was.
            yield frame
            self._file.seek(offset)

    def messages(self, kind: str | None = None) -> Iterator[Message]:
        """Everything that was published, or what has this name, in its order."""
        wanted = None if kind is None else kind_id(kind)
        for frame in self.frames():
            if frame.kind != KIND_TICK:
                continue
            record = _table(frame.payload)
            for number, time_ns, payload in _split(record["log"]):
                if wanted is None or number == wanted:
                    yield Message(frame.tick, time_ns * 1e-9, self._names.get(number), unpack(payload))

    def result(self) -> dict[str, Any] | None:
        """The result as the module gave it: verdict, score, metrics in SI units; `None` if the run did not come to one."""
        last = None
        for message in self.messages("training.result"):
            last = message.content
        return last

    def attempt(self, path: str = "") -> Attempt:
        """The session with its result, as the store has it; `id` is empty where the session has none."""
        result, plan = self.result(), self.plan
        verdict = "incomplete"
        if result is not None:
            if result["aborted"]:
                verdict = "aborted"
            elif result.get("not_judged"):
                verdict = "not-judged"
            else:
                verdict = "passed" if result["passed"] else "failed"
        if result is not None:
            metrics, duration = result["metrics"], result["duration"]
        else:
            running = [message.content["running"] for message in self.messages("level.state")]
            metrics, duration = [], running[-1] if running else 0.0
        return Attempt(
            id=self.header.get("id") or "",
            path=path,
            trainee=self.header.get("trainee"),
            module=plan["module"],
            level=plan["level"],
            started=self.header["started"],
            verdict=verdict,
            counts=verdict in ("passed", "failed") and not plan["without"],
            synthetic=plan.get("synthetic"),
            score=result["score"] if result is not None and verdict != "not-judged" else None,
            duration=duration,
            metrics={metric["id"]: metric["value"] for metric in metrics if metric["value"] is not None},
        )

    def tool_motion(self, tool: str | None = None) -> list[dict[str, Any]]:
        """Where the tools were, a row for each tool and tick: time [s], tool, status, x, y, z [m], qx, qy, qz, qw, opening 0 to 1."""
        rows = []
        for message in self.messages("tool.states"):
            for state in message.content["tools"]:
                if tool in (None, state["tool"]):
                    position, orientation = state["pose"]["position"], state["pose"]["orientation"]
                    row = {"time": message.time, "tool": state["tool"], "status": state["status"]}
                    row.update(zip(("x", "y", "z"), position))
                    row.update(zip(("qx", "qy", "qz", "qw"), orientation))
                    row["opening"] = state["opening"]
                    rows.append(row)
        return rows


def attempts_in(folder: str | os.PathLike[str]) -> list[Attempt]:
    """The attempts of all sessions of a folder, by time. A file that is none, or of which nothing can be read, is an error with its name."""
    found = []
    for path in sorted(Path(folder).glob("*.session")):
        try:
            with Session.open(path) as session:
                start = (session.header["started"], session.header.get("started_subsec_ns", 0), str(path))
                found.append((start, session.attempt(str(path))))
        except (NotASession, NotMessagePack) as error:
            raise NotASession(f"{path}: {error}") from error
    return [attempt for _, attempt in sorted(found, key=lambda pair: pair[0])]


def _table(payload: bytes) -> dict[str, Any]:
    value = unpack(payload)
    if not isinstance(value, dict):
        raise NotMessagePack("a record that is no table")
    return value


def _split(log: bytes) -> Iterator[tuple[int, int, bytes]]:
    """The messages of a tick: number of the kind, time [ns], payload."""
    at = 0
    while at < len(log):
        if len(log) - at < _MESSAGE.size:
            raise NotMessagePack(f"{len(log) - at} bytes left of a tick, a message has {_MESSAGE.size} at least")
        kind, time_ns, size, _version, _sender = _MESSAGE.unpack_from(log, at)
        at += _MESSAGE.size
        if size > len(log) - at:
            raise NotMessagePack(f"a message of {size} bytes announced, {len(log) - at} there")
        yield kind, time_ns, log[at : at + size]
        at += size
