"""Stores: made here with the tables that MicroSim makes, whose SQL stands in `crates/store/src/schema.rs`; and one that MicroSim has
written, which `MICROSIM_STORE` names."""

import os
import re
import sqlite3
import tempfile
import unittest
from pathlib import Path

import microsim
from microsim.store import APPLICATION, VERSION

SCHEMA = Path(__file__).resolve().parents[2] / "crates" / "store" / "src" / "schema.rs"


def steps() -> list[str]:
    """The SQL of each version after the one before."""
    return re.findall(r'const VERSION_\d+: &str =\s+"(.*?)";', SCHEMA.read_text(encoding="utf-8"), re.DOTALL)


@unittest.skipUnless(SCHEMA.is_file(), f"there is no {SCHEMA} with the tables of a store")
class Made(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        # A name that an address has to quote.
        self.path = Path(folder.name) / "a store?#%.sqlite"
        connection = sqlite3.connect(self.path)
        for step in steps():
            connection.executescript(step)
        connection.execute(f"PRAGMA application_id = {APPLICATION}")
        connection.execute(f"PRAGMA user_version = {len(steps())}")
        connection.executescript(
            """
            INSERT INTO trainee VALUES (1, 'aa', 'A. Muster', 'trainee', 5), (2, 'bb', NULL, 'instructor', 6), (3, 'cc', 'Ä "x"', 'trainee', 7);
            INSERT INTO trainee_group VALUES (1, 'Novices'), (2, 'Experts');
            INSERT INTO membership VALUES (1, 1), (2, 2), (1, 3);
            INSERT INTO metric (key, id, title, unit, display_unit, display_factor, direction, category, formula)
                VALUES (1, 'path-length', 'Path', 'm', 'mm', 1000, 'lower-is-better', 'x', 'path-length/1'),
                       (2, 'tremor', 'Tremor', 'm', 'mm', 1000, 'lower-is-better', 'x', 'tremor/1');
            """
        )
        row = {
            "path": "p", "module": "coordination", "level": 2, "simulated": 1.0, "finished": 1, "seed": "1", "input": "i", "version": "v",
            "realtime": 0, "verdict": "passed", "counts": 1, "failed": "", "duration": 3.0, "targets_done": 1, "targets": 1, "score": 50.0,
        }
        for changed in [
            {"key": 1, "id": "s1", "trainee": 1, "started": 20, "started_subsec_ns": 30},
            {"key": 2, "id": "s2", "trainee": 2, "started": 20, "started_subsec_ns": 10, "verdict": "failed", "score": None},
            {"key": 3, "id": "s3", "trainee": None, "started": 30, "synthetic": "profile novice, seed 1"},
            {"key": 4, "id": "s4", "trainee": 1, "started": 40, "counts": 0, "verdict": "aborted", "level": 3},
        ]:
            values = row | changed
            names = ", ".join(values)
            marks = ", ".join("?" * len(values))
            connection.execute(f"INSERT INTO session ({names}) VALUES ({marks})", list(values.values()))
        connection.execute("INSERT INTO metric_value (session, metric, value) VALUES (1, 1, 0.25), (1, 2, NULL)")
        connection.commit()
        connection.close()

    def ids(self, **chosen: object) -> list[str]:
        with microsim.Store.open(self.path) as store:
            return [attempt.id for attempt in store.attempts(**chosen)]  # type: ignore[arg-type]

    def test_this_package_knows_the_tables(self) -> None:
        self.assertEqual(len(steps()), VERSION)

    def test_tables_of_the_first_version_are_read(self) -> None:
        path = self.path.with_name("first.sqlite")
        connection = sqlite3.connect(path)
        connection.executescript(steps()[0])
        connection.execute(f"PRAGMA application_id = {APPLICATION}")
        connection.execute("PRAGMA user_version = 1")
        connection.commit()
        connection.close()
        with microsim.Store.open(path) as store:
            self.assertEqual(list(store.attempts()), [])

    def test_attempts_are_those_that_are_asked_for_by_time(self) -> None:
        self.assertEqual(self.ids(), ["s2", "s1", "s3"])
        self.assertEqual(self.ids(counting=False), ["s2", "s1", "s3", "s4"])
        self.assertEqual(self.ids(trainee="aa"), ["s1"])
        self.assertEqual(self.ids(trainee="A. Muster", counting=False), ["s1", "s4"])
        self.assertEqual(self.ids(group="Experts"), ["s2"])
        self.assertEqual(self.ids(level=3, counting=False), ["s4"])
        self.assertEqual(self.ids(synthetic=True), ["s3"])
        self.assertEqual(self.ids(synthetic=False), ["s2", "s1"])
        # A name is a name, whatever is in it.
        self.assertEqual(self.ids(trainee="' OR 1=1 --"), [])

    def test_an_attempt_has_what_was_measured(self) -> None:
        with microsim.Store.open(self.path) as store:
            failed, passed, _ = store.attempts()
            self.assertEqual((passed.trainee, passed.passed, passed.score), ("aa", True, 50.0))
            self.assertEqual(dict(passed.metrics), {"path-length": 0.25})
            self.assertEqual([passed.value(what) for what in ("path-length", "tremor", "duration", "score")], [0.25, None, 3.0, 50.0])
            self.assertEqual((failed.passed, failed.score), (False, None))
            self.assertEqual([t.id for t in store.trainees("Novices")], ["aa", "cc"])
            self.assertEqual([t.name for t in store.trainees()], [None, "A. Muster", 'Ä "x"'])
            self.assertEqual(store.groups(), ["Experts", "Novices"])

    def test_nothing_is_written(self) -> None:
        before = self.path.read_bytes()
        with microsim.Store.open(self.path) as store:
            with self.assertRaises(sqlite3.OperationalError):
                store._connection.execute("DELETE FROM session")
        self.assertEqual(self.path.read_bytes(), before)

    def test_what_is_no_store_or_a_later_one_is_refused_in_words(self) -> None:
        connection = sqlite3.connect(self.path)
        connection.execute(f"PRAGMA user_version = {VERSION + 1}")
        connection.close()
        with self.assertRaisesRegex(microsim.NotAStore, f"version {VERSION + 1}.*1 to {VERSION}"):
            microsim.Store.open(self.path)
        connection = sqlite3.connect(self.path)
        connection.execute("PRAGMA application_id = 7")
        connection.close()
        with self.assertRaisesRegex(microsim.NotAStore, "no store of MicroSim"):
            microsim.Store.open(self.path)
        self.path.write_bytes(b"something else, longer than the head of a database" * 20)
        with self.assertRaisesRegex(microsim.NotAStore, "cannot be read"):
            microsim.Store.open(self.path)
        with self.assertRaises(FileNotFoundError):
            microsim.Store.open(self.path.with_name("none"))


@unittest.skipUnless("MICROSIM_STORE" in os.environ, "no store is named by MICROSIM_STORE")
class Written(unittest.TestCase):
    def test_it_has_attempts(self) -> None:
        with microsim.Store.open(os.environ["MICROSIM_STORE"]) as store:
            attempts = list(store.attempts(counting=False))
        self.assertTrue(attempts)
        for attempt in attempts:
            # The session that it is of gives the same, but for where it lies.
            with microsim.Session.open(attempt.path) as session:
                found = session.attempt(attempt.path)
            self.assertEqual((found.module, found.level, found.verdict), (attempt.module, attempt.level, attempt.verdict))
            self.assertEqual((found.score, dict(found.metrics)), (attempt.score, dict(attempt.metrics)))


class Place(unittest.TestCase):
    def test_it_lies_where_microsim_has_it(self) -> None:
        kept = {name: os.environ.pop(name, None) for name in ("MICROSIM_DATA", "XDG_DATA_HOME")}
        try:
            self.assertEqual(microsim.default_store(), Path.home() / ".local/share/microsim/store.sqlite")
            os.environ["XDG_DATA_HOME"] = "/x"
            self.assertEqual(microsim.default_store(), Path("/x/microsim/store.sqlite"))
            os.environ["MICROSIM_DATA"] = "/y"
            self.assertEqual(microsim.default_store(), Path("/y/store.sqlite"))
        finally:
            for name, value in kept.items():
                os.environ.pop(name, None)
                if value is not None:
                    os.environ[name] = value


if __name__ == "__main__":
    unittest.main()
