"""Studies: many cases over ranges of their parameters, restartable, on all cores or a cluster."""

from celltrain.study.collect import save_dataset, study_dataset, table
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
from celltrain.study.engine import Progress, WorkersLost, run_study
from celltrain.study.quantities import STUDY_QUANTITIES
from celltrain.study.store import Record, Store
from celltrain.study.workers import Workers, local_workers, scheduled_workers

__all__ = [
    "STUDY_QUANTITIES",
    "Axis",
    "Case",
    "Computation",
    "Computed",
    "Outcome",
    "Progress",
    "Record",
    "StabilityOfCase",
    "Store",
    "Study",
    "Workers",
    "WorkersLost",
    "describe",
    "local_workers",
    "make_study",
    "read_study",
    "run_study",
    "save_dataset",
    "scheduled_workers",
    "study_dataset",
    "table",
]
