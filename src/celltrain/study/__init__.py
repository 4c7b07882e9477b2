"""Studies: many cases over ranges of their parameters, restartable, on all cores or a cluster."""

from celltrain.study.collect import collect
from celltrain.study.computation import Computation, Outcome, StabilityOfCase
from celltrain.study.definition import (
    Axis,
    Case,
    Computed,
    Study,
    describe,
    make_study,
    read_study,
)
from celltrain.study.engine import NotKept, StudyProgress, WorkersLost, run_study
from celltrain.study.result import StudyResult
from celltrain.study.store import CaseRecord, Store
from celltrain.study.workers import Workers, local_workers, scheduled_workers

__all__ = [
    "Axis",
    "Case",
    "CaseRecord",
    "Computation",
    "Computed",
    "NotKept",
    "Outcome",
    "StabilityOfCase",
    "Store",
    "Study",
    "StudyProgress",
    "StudyResult",
    "Workers",
    "WorkersLost",
    "collect",
    "describe",
    "local_workers",
    "make_study",
    "read_study",
    "run_study",
    "scheduled_workers",
]
