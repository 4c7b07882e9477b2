"""The folder of a study: a record and a steady train for each case, by the case's address.

An address is a hash of everything that a result depends on: the complete parameters, what is
computed, and the package's version. So a case that was ever finished is found again, also by
another study in the same folder, and never by one that would compute anything else. Records are
written last, and every file at once (see `results.replace`): a record that is there is whole.
"""

import hashlib
import json
import math
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, ValidationError

from celltrain.parameters import Train
from celltrain.results import read, remove_leftovers, replace_file, save
from celltrain.steady import Base
from celltrain.study.computation import Outcome
from celltrain.version import __version__


class CaseRecord(BaseModel):
    """What is known of a case that was computed, or that failed.

    `values` are by the names of their columns, None where there is no number; `reason`
    says why a case failed.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    address: str
    version: str
    status: Literal["finished", "failed"]
    reason: str
    origin: str
    case: dict[str, dict[str, Any]]
    computed: dict[str, Any]
    values: dict[str, float | None]


class Store:
    """The cases of one folder that are finished or failed, for one way of computing them."""

    def __init__(self, folder: Path, settings: dict[str, Any]) -> None:
        self._folder = folder
        self._settings = settings

    def address(self, train: Train) -> str:
        """The case's address, 24 hexadecimal digits.

        Scales are left out, as they do not enter a dimensionless computation.
        """
        content = {"version": __version__, "case": train.sections(), "computed": self._settings}
        text = json.dumps(content, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:24]

    def record(self, train: Train) -> CaseRecord | None:
        """The record of a case; None if there is none, or none that can be read."""
        try:
            return CaseRecord.model_validate_json(self._path(train, "json").read_bytes())
        except (OSError, ValidationError):
            return None

    def base(self, train: Train) -> Base:
        """The steady train of a case that is finished.

        **Raises:** `OSError` or `ValueError` if it cannot be read.
        """
        return read(self._path(train, "nc"), Base)

    def finish(self, train: Train, outcome: Outcome) -> CaseRecord:
        """Keep what came of a case.

        **Raises:** `OSError` if it cannot be written.
        """
        save(outcome.base, self._path(train, "nc"))
        return self._write(train, "finished", "", outcome.base.origin, outcome.values)

    def fail(self, train: Train, reason: str) -> CaseRecord:
        """Keep why a case failed.

        **Raises:** `OSError` if it cannot be written.
        """
        return self._write(train, "failed", reason, "", {})

    def tidy(self, train: Train) -> None:
        """Remove what killed processes have left of a case's files."""
        for ending in ("json", "nc"):
            remove_leftovers(self._path(train, ending))

    def _path(self, train: Train, ending: str) -> Path:
        return self._folder / f"{self.address(train)}.{ending}"

    def _write(
        self,
        train: Train,
        status: Literal["finished", "failed"],
        reason: str,
        origin: str,
        values: dict[str, float],
    ) -> CaseRecord:
        record = CaseRecord(
            address=self.address(train),
            version=__version__,
            status=status,
            reason=reason,
            origin=origin,
            case=train.sections(),
            computed=self._settings,
            values={
                name: value if math.isfinite(value) else None for name, value in values.items()
            },
        )
        text = record.model_dump_json(indent=2) + "\n"
        replace_file(
            self._path(train, "json"), lambda part: part.write_text(text, encoding="utf-8")
        )
        return record
