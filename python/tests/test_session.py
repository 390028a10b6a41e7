"""Sessions: one that MicroSim has recorded, and what is wrong with one.

`MICROSIM_SESSION` names a session; the report that MicroSim has written beside it (`NAME.json`) is what is compared with. Without it the
recorded sessions of `tests/data/old-sessions` are read alone.
"""

import gzip
import json
import os
import struct
import unittest
import zlib
from pathlib import Path

import microsim
from microsim.messagepack import NotMessagePack, unpack
from microsim.session import KIND_END, KIND_HEADER, KIND_TICK, MAGIC, kind_id

OLD = Path(__file__).resolve().parents[2] / "tests" / "data" / "old-sessions"


def old_sessions() -> list[tuple[str, bytes]]:
    return [(path.name, gzip.decompress(path.read_bytes())) for path in sorted(OLD.glob("*.session.gz"))]


def frame(kind: int, sequence: int, tick: int, payload: bytes) -> bytes:
    """As `crates/session/src/lib.rs` documents it."""
    head = struct.pack("<IBQQI", len(payload), kind, sequence, tick, zlib.crc32(payload))
    return head + struct.pack("<I", zlib.crc32(head)) + payload


class MessagePack(unittest.TestCase):
    def test_values_of_the_specification(self) -> None:
        # Encoded by hand from the format's specification (msgpack.org).
        values: list[tuple[bytes, object]] = [
            (b"\x07", 7),
            (b"\xff", -1),
            (b"\xc0", None),
            (b"\xc2", False),
            (b"\xc3", True),
            (b"\xcd\x01\x00", 256),
            (b"\xd1\xff\x00", -256),
            (b"\xcf" + b"\xff" * 8, 2**64 - 1),
            (b"\xcb\x3f\xf8" + b"\x00" * 6, 1.5),
            (b"\xa2\xc3\xa4", "ä"),
            (b"\x92\x01\xc4\x02ab", [1, b"ab"]),
            (b"\x81\xa1a\x90", {"a": []}),
            (b"\xdc\x00\x01\x05", [5]),
            (b"\xde\x00\x01\xa1x\xca\x3f\x00\x00\x00", {"x": 0.5}),
        ]
        for data, value in values:
            self.assertEqual(unpack(data), value)

    def test_what_is_none_is_refused_before_it_takes_memory(self) -> None:
        for data in [
            b"",
            b"\xa5ab",
            b"\xc1",
            b"\xdd\xff\xff\xff\xff",
            b"\xdf\xff\xff\xff\xff\x01",
            b"\xc6\xff\xff\xff\xffx",
            b"\x01\x02",
            b"\x91" * 1000 + b"\x01",
            b"\xa1\xff",
            b"\x81\x90\x01",
        ]:
            with self.assertRaises(NotMessagePack):
                unpack(data)


class Old(unittest.TestCase):
    def test_sessions_of_all_versions_are_read(self) -> None:
        sessions = old_sessions()
        self.assertGreaterEqual(len(sessions), 4)
        for name, data in sessions:
            with microsim.Session.read(data) as session:
                attempt = session.attempt()
                self.assertTrue(session.ending is not None and session.ending.is_complete, name)
                self.assertIn(attempt.module, name)
                self.assertEqual(attempt.verdict, "failed")
                # One state of a tool a tick.
                ticks = sum(record.kind == KIND_TICK for record in session.frames())
                self.assertEqual(len(session.tool_motion()), ticks, name)

    def test_every_cut_is_noticed_and_what_is_whole_is_read(self) -> None:
        _, data = min(old_sessions(), key=lambda named: len(named[1]))
        with microsim.Session.read(data) as session:
            records = list(session.frames())
        ends = [record.offset for record in records[1:]] + [len(data)]
        # Around each of the first and last records, and in between at steps that hit every place of a record.
        cuts = set(range(ends[0], ends[0] + 60)) | set(range(len(data) - 60, len(data))) | set(range(ends[0], len(data), len(data) // 50))
        for cut in sorted(cuts):
            with microsim.Session.read(data[:cut]) as session:
                read = len(list(session.frames()))
                assert session.ending is not None
                expected = "open" if cut in ends else "torn"
                self.assertEqual((session.ending.state, read), (expected, sum(end <= cut for end in ends)), cut)
        for cut in range(0, ends[0], 101):
            with self.assertRaises(microsim.NotASession):
                microsim.Session.read(data[:cut])

    def test_every_flipped_bit_is_noticed(self) -> None:
        _, data = min(old_sessions(), key=lambda named: len(named[1]))
        with microsim.Session.read(data) as session:
            second = list(session.frames())[1].offset
        places = list(range(second, second + 60)) + list(range(second, len(data), len(data) // 50))
        for place in places:
            flipped = bytearray(data)
            flipped[place] ^= 1 << place % 8
            with microsim.Session.read(bytes(flipped)) as session:
                for _ in session.frames():
                    pass
                # A length that is longer than the file is one that does not fit its checksum, too.
                self.assertEqual(session.ending and session.ending.state, "damaged", place)

    def test_what_is_no_session_is_refused_in_words(self) -> None:
        _, data = old_sessions()[0]
        other = MAGIC + struct.pack("<I", 2) + data[21:]
        for wrong, word in [(b"", "begin"), (b"text" * 20, "begin"), (MAGIC, "ends before"), (other, "format 2")]:
            with self.assertRaisesRegex(microsim.NotASession, word):
                microsim.Session.read(wrong)

    def test_records_in_the_wrong_place_are_damage(self) -> None:
        _, data = old_sessions()[1]
        with microsim.Session.read(data) as session:
            first, second, *_ = list(session.frames())
        begin = data[:21] + frame(KIND_HEADER, 0, 0, first.payload)
        for rest, what in [
            (frame(KIND_TICK, 2, 0, second.payload), "record 2 where record 1 belongs"),
            (frame(KIND_END, 1, 0, b"") + b"x", "bytes behind"),
        ]:
            with microsim.Session.read(begin + rest) as session:
                list(session.frames())
                assert session.ending is not None
                self.assertIn(what, session.ending.what or "")

    def test_a_later_format_of_records_is_named(self) -> None:
        header = b"\x81\xa6format\x63"
        with self.assertRaisesRegex(microsim.NotASession, "format 99"):
            microsim.Session.read(MAGIC + struct.pack("<I", 1) + frame(KIND_HEADER, 0, 0, header))

    def test_numbers_of_kinds(self) -> None:
        # FNV-1a of an empty text and of "a": the published values.
        self.assertEqual((kind_id(""), kind_id("a")), (0xCBF29CE484222325, 0xAF63DC4C8601EC8C))


@unittest.skipUnless("MICROSIM_SESSION" in os.environ, "no session of this build is named by MICROSIM_SESSION")
class Recorded(unittest.TestCase):
    def setUp(self) -> None:
        self.path = Path(os.environ["MICROSIM_SESSION"])
        self.report = json.loads(self.path.with_suffix(".json").read_text(encoding="utf-8"))

    def test_the_result_is_that_of_the_report(self) -> None:
        with microsim.Session.open(self.path) as session:
            attempt = session.attempt(str(self.path))
            assert session.ending is not None
            self.assertEqual(session.ending.state, "clean")
            self.assertEqual(session.header["version"], self.report["session"]["version"])
        report, of = self.report, self.report["session"]
        self.assertEqual((attempt.module, attempt.level, attempt.started), (of["module"], of["level"], of["started"]))
        self.assertEqual((attempt.verdict, attempt.counts), (report["verdict"], report["counts"]))
        self.assertEqual((attempt.score, attempt.duration), (report["score"], report["duration"]))
        values = {metric["id"]: metric["value"] for metric in report["metrics"] if metric["value"] is not None}
        self.assertTrue(values)
        self.assertEqual(dict(attempt.metrics), values)

    def test_the_motion_is_that_of_the_report(self) -> None:
        with microsim.Session.open(self.path) as session:
            rows = session.tool_motion()
        self.assertTrue(rows)
        for series in self.report["series"]:
            placed = {(row["x"], row["y"], row["z"]) for row in rows if row["tool"] == series["tool"]}
            # The tool stands in each tick where its last sample was.
            missing = [at for at in map(tuple, series["position"]) if at not in placed]
            self.assertLessEqual(len(missing), 0.05 * len(series["position"]), series["tool"])


if __name__ == "__main__":
    unittest.main()
