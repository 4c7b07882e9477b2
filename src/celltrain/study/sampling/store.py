"""The numbers of all trains of samples in one file: an SQLite database in the study's folder.

Ten thousand trains would be twenty thousand small files. The trains of a point are added in one
transaction, which SQLite has on the disk before they count as finished: a process that is killed,
or a machine that stops, at any moment leaves all of them or none, and what was added before. Only
the process that runs the study writes to it.

A train's address is a hash of everything that its numbers depend on, as in `study.store`: so
another sample in the same folder finds those trains that it shares with this one.
"""

import hashlib
import json
import math
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from celltrain.parameters import CaseError, Train
from celltrain.study.sampling.draws import DrawRecord
from celltrain.version import __version__

#: Name of the file.
FILE = "trains.sqlite"
_TABLE = """
CREATE TABLE IF NOT EXISTS trains (
    address TEXT PRIMARY KEY,
    version TEXT NOT NULL,
    status TEXT NOT NULL,
    reason TEXT NOT NULL,
    numbers TEXT NOT NULL
) WITHOUT ROWID
"""
_COLUMNS = ["address", "version", "status", "reason", "numbers"]
_ADD = "INSERT OR REPLACE INTO trains VALUES (?, ?, ?, ?, ?)"


class DrawStore:
    """The trains that a folder has numbers of, for one way of computing them.

    **Raises:** `CaseError` if the file is there, but no such database; `OSError` if it cannot be
    opened or written.
    """

    def __init__(self, connection: sqlite3.Connection, settings: Mapping[str, object]) -> None:
        self._connection = connection
        self._settings = dict(settings)
        self._version = __version__

    def address(self, train: Train, *, checked: bool) -> str:
        """The train's address, 24 hexadecimal digits; scales are left out."""
        computed = {**self._settings, "checked": checked}
        content = {"version": self._version, "case": train.sections(), "computed": computed}
        text = json.dumps(content, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:24]

    def records(self) -> dict[str, DrawRecord]:
        """Everything that this version has kept, by address."""
        query = "SELECT address, status, reason, numbers FROM trains WHERE version = ?"
        with _as_os_error():
            rows = self._connection.execute(query, (self._version,)).fetchall()
        return {
            address: DrawRecord(status, reason, _numbers(text))
            for address, status, reason, text in rows
        }

    def add(self, records: Mapping[str, DrawRecord]) -> None:
        """Keep records, all of them at once.

        **Raises:** `OSError` if they cannot be written; none of them is there then.
        """
        rows = [
            (address, self._version, record.status, record.reason, _text(record.values))
            for address, record in records.items()
        ]
        with _as_os_error(), self._connection:
            self._connection.executemany(_ADD, rows)


@contextmanager
def draw_store(folder: Path, settings: Mapping[str, object]) -> Iterator[DrawStore]:
    """The store of a folder, which is there; its file is made if need be.

    **Raises:** as `DrawStore`.
    """
    path = folder / FILE
    with _as_os_error():
        connection = sqlite3.connect(path)
    try:
        try:
            # Each transaction is on the disk before it counts.
            connection.execute("PRAGMA synchronous = EXTRA")
            with connection:
                connection.execute(_TABLE)
            found = [row[1] for row in connection.execute("PRAGMA table_info(trains)")]
            if found != _COLUMNS:
                raise sqlite3.DatabaseError(f"it has a table with {', '.join(found)}")
        except sqlite3.OperationalError as error:
            raise OSError(str(error)) from None
        except sqlite3.DatabaseError as error:
            raise CaseError(
                f"output = {str(folder)!r} is not allowed: {FILE} in it is no file of a sample"
                f" ({error}); allowed: another folder, or this one without that file"
            ) from None
        yield DrawStore(connection, settings)
    finally:
        connection.close()


@contextmanager
def _as_os_error() -> Iterator[None]:
    """What SQLite says of disks and files, as the error of the system that it is."""
    try:
        yield
    except sqlite3.Error as error:
        raise OSError(str(error)) from None


def _text(values: Mapping[str, float]) -> str:
    finite = {name: value if math.isfinite(value) else None for name, value in values.items()}
    return json.dumps(finite)


def _numbers(text: str) -> dict[str, float]:
    found: dict[str, float | None] = json.loads(text)
    return {name: math.nan if value is None else value for name, value in found.items()}
