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
)
from celltrain.study.dispatch import NotKept, StudyProgress, WorkersLost
from celltrain.study.engine import compute_study, run_study
from celltrain.study.reading import read_study
from celltrain.study.result import StudyResult
from celltrain.study.sampling.collect import collect_sample
from celltrain.study.sampling.definition import SampledStudy, make_sampled_study
from celltrain.study.sampling.engine import NoCentralTrain, Sampled, run_sample
from celltrain.study.sampling.result import SampleResult
from celltrain.study.store import CaseRecord, Store
from celltrain.study.workers import Workers, local_workers, scheduled_workers

__all__ = [
    "Axis",
    "Case",
    "CaseRecord",
    "Computation",
    "Computed",
    "NoCentralTrain",
    "NotKept",
    "Outcome",
    "SampleResult",
    "Sampled",
    "SampledStudy",
    "StabilityOfCase",
    "Store",
    "Study",
    "StudyProgress",
    "StudyResult",
    "Workers",
    "WorkersLost",
    "collect",
    "collect_sample",
    "compute_study",
    "describe",
    "local_workers",
    "make_sampled_study",
    "make_study",
    "read_study",
    "run_sample",
    "run_study",
    "scheduled_workers",
]
