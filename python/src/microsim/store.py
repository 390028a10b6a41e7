"""The store: trainees, groups and results, read from its SQLite file.

The file is opened read-only, while MicroSim may be writing it. Its tables stand in `crates/store/src/schema.rs`; this package reads versions
1 to the one of `VERSION`, and refuses later ones with both numbers. `default_store()` is where MicroSim has it (`microsim doctor`).

    with Store.open(default_store()) as store:
        for attempt in store.attempts(module="coordination", level=2):
            print(attempt.trainee, attempt.verdict, attempt.score)
"""

from __future__ import annotations

import os
import sqlite3
import urllib.parse
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from .attempt import Attempt

# `application_id` of the file: MSIM.
APPLICATION = 0x4D53494D
# The last version of the tables that this package knows.
VERSION = 2


class NotAStore(ValueError):
    """A file that is no store, or one of a later version."""


@dataclass(frozen=True)
class Trainee:
    """Who trains."""

    id: str
    # `None`: anonymous.
    name: str | None
    role: str


def default_store() -> Path:
    """Where MicroSim has its store, by the rules of `microsim`: below MICROSIM_DATA, else in the data folder of the user (XDG)."""
    if named := os.environ.get("MICROSIM_DATA"):
        return Path(named).absolute() / "store.sqlite"
    home = os.environ.get("XDG_DATA_HOME", "")
    data = Path(home) if os.path.isabs(home) else Path.home() / ".local" / "share"
    return data / "microsim" / "store.sqlite"


class Store:
    """A store that is read."""

    def __init__(self, connection: sqlite3.Connection) -> None:
        self._connection = connection
        try:
            (application,) = connection.execute("PRAGMA application_id").fetchone()
            (version,) = connection.execute("PRAGMA user_version").fetchone()
        except sqlite3.DatabaseError as error:
            raise NotAStore(f"it cannot be read: {error}") from error
        if application != APPLICATION:
            raise NotAStore("it is no store of MicroSim")
        if not 1 <= version <= VERSION:
            raise NotAStore(f"tables of version {version}; this package reads versions 1 to {VERSION}")
        # Version 1 has no order within a second.
        self._start = "session.started, session.started_subsec_ns" if version > 1 else "session.started"

    @classmethod
    def open(cls, path: str | os.PathLike[str]) -> Store:
        """Opens a file read-only; close it, or use `with`."""
        path = Path(path).absolute()
        if not path.is_file():
            raise FileNotFoundError(f"{path}: there is no such file")
        address = f"file:{urllib.parse.quote(str(path))}?mode=ro"
        connection = sqlite3.connect(address, uri=True)
        try:
            return cls(connection)
        except BaseException:
            connection.close()
            raise

    def close(self) -> None:
        """Closes the file."""
        self._connection.close()

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def trainees(self, group: str | None = None) -> list[Trainee]:
        """All trainees, or the members of a group, by name."""
        sql = "SELECT id, name, role FROM trainee"
        values: list[object] = []
        if group is not None:
            sql += f" WHERE {_IN_GROUP.format('trainee.key')}"
            values.append(group)
        rows = self._connection.execute(sql + " ORDER BY name, id", values)
        return [Trainee(*row) for row in rows]

    def groups(self) -> list[str]:
        """The names of all groups."""
        return [name for (name,) in self._connection.execute("SELECT name FROM trainee_group ORDER BY name")]

    def attempts(
        self,
        *,
        trainee: str | None = None,
        group: str | None = None,
        module: str | None = None,
        level: int | None = None,
        counting: bool = True,
        synthetic: bool | None = None,
    ) -> Iterator[Attempt]:
        """Sessions in the order in which they were begun, of a trainee (by id or name), a group, a module, a level; without
        `counting` also those that are no results, with `synthetic` those of synthetic trainees alone or those of people alone."""
        parts, values = ["1"], []  # type: list[str], list[object]
        if trainee is not None:
            parts.append("(trainee.id = ? OR trainee.name = ?)")
            values += [trainee, trainee]
        if group is not None:
            parts.append(_IN_GROUP.format("session.trainee"))
            values.append(group)
        if module is not None:
            parts.append("session.module = ?")
            values.append(module)
        if level is not None:
            parts.append("session.level = ?")
            values.append(level)
        if counting:
            parts.append("session.counts = 1")
        if synthetic is not None:
            parts.append("session.synthetic IS NOT NULL" if synthetic else "session.synthetic IS NULL")
        sessions = self._connection.execute(
            "SELECT session.key, session.id, session.path, trainee.id, session.module, session.level, session.started,"
            " session.verdict, session.counts, session.synthetic, session.score, session.duration FROM session"
            " LEFT JOIN trainee ON trainee.key = session.trainee"
            f" WHERE {' AND '.join(parts)} ORDER BY {self._start}, session.id",
            values,
        )
        for key, *row in sessions:
            metrics = self._connection.execute(
                "SELECT metric.id, metric_value.value FROM metric_value JOIN metric ON metric.key = metric_value.metric"
                " WHERE metric_value.session = ? AND metric_value.value IS NOT NULL ORDER BY metric.id",
                [key],
            )
            id, path, who, module_, level_, started, verdict, counts, made, score, duration = row
            yield Attempt(
                id, path, who, module_, level_, started, verdict, bool(counts), made, score, duration, dict(metrics)
            )


_IN_GROUP = (
    "{} IN (SELECT membership.trainee FROM membership JOIN trainee_group ON trainee_group.key = membership.trainee_group"
    " WHERE trainee_group.name = ?)"
)
