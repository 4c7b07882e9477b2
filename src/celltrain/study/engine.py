"""The run of a study: which case is computed when, from where, and what becomes of it.

Cases go to any executor, one for each of its slots at a time, so that where a case may start from
is decided as late as possible. Workers write their results themselves: what is finished outlives
whoever asked for it.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from importlib.util import find_spec
from pathlib import Path

from celltrain.contract import Crew
from celltrain.parameters import Train
from celltrain.results import only_writer
from celltrain.steady import Base
from celltrain.study.collect import collect
from celltrain.study.computation import Computation, Outcome, StabilityOfCase
from celltrain.study.definition import Case, Study
from celltrain.study.dispatch import TRIES, NotKept, StudyProgress, WorkerDied, work_through
from celltrain.study.result import StudyResult
from celltrain.study.store import CaseRecord, Store


def compute_case(
    computation: Computation, folder: Path, train: Train, start: Train | None
) -> CaseRecord:
    """Compute a case and keep what comes of it, in a worker; `start` is a finished case.

    **Raises:** `NotKept` if it cannot be written.
    """
    store = Store(folder, computation.settings)
    with _own_locks():
        # A worker that dies takes its last answer along, if nobody has fetched it yet; the case is
        # then given to another one, though it is finished.
        record = store.record(train)
        if record is not None and record.status == "finished":
            return record
        try:
            base = None if start is None else _readable_base(store, start)
            outcome: Outcome | str = computation(train, base)
        except Exception as error:
            outcome = f"{type(error).__name__}: {error}"
        try:
            if isinstance(outcome, str):
                return store.fail(train, outcome)
            return store.finish(train, outcome)
        except OSError as error:
            # Of its own type, as lost connections are errors of the system, too.
            raise NotKept(error.strerror or str(error)) from None


def _own_locks() -> AbstractContextManager[object]:
    """Files are locked in this process alone.

    In a dask worker, xarray would ask the scheduler for each lock, which may have gone by then; no
    two processes write the same file.
    """
    if find_spec("dask") is None:
        return nullcontext()
    import dask

    return dask.config.set(scheduler="threads")


def _readable_base(store: Store, train: Train) -> Base | None:
    """The steady train of a case, if somebody has not removed it meanwhile."""
    try:
        return store.base(train)
    except (OSError, ValueError):
        return None


def run_study(
    study: Study,
    folder: Path,
    computation: Computation,
    executor: Executor,
    slots: Callable[[], int],
    *,
    retry: bool = False,
    progress: Callable[[StudyProgress], None] | None = None,
) -> dict[tuple[int, ...], CaseRecord]:
    """Compute the cases of a study that the folder has no result of.

    **Arguments:**

    - `folder`: where the results are; it must exist, and workers must see it by the same name.
    - `executor`, `slots`: what computes, and how many cases at a time.
    - `retry`: compute failed cases again.
    - `progress`: called at the start, and whenever a case ends.

    **Returns:** the records by the cases' indices.

    **Raises:** `CaseError` if another process writes to the folder; `WorkersLost` if the executor
    gives up; `NotKept` or `OSError` if the folder cannot be written.
    """
    with only_writer(folder):
        return _run(study, folder, computation, executor, slots, retry=retry, progress=progress)


def compute_study(study: Study, folder: Path, crew: Crew) -> StudyResult:
    """Run or resume a study in a folder, which is there.

    Raises:
        CaseError: if another process writes to the folder.
        ComputationFailed, KeyboardInterrupt: as `celltrain.contract.Crew`.
    """
    computation = StabilityOfCase(study.computed)
    run = partial(run_study, study, folder.absolute(), computation)
    return collect(study, crew(run, study.title, len(study.cases)))


def _run(
    study: Study,
    folder: Path,
    computation: Computation,
    executor: Executor,
    slots: Callable[[], int],
    *,
    retry: bool,
    progress: Callable[[StudyProgress], None] | None,
) -> dict[tuple[int, ...], CaseRecord]:
    work = _Cases(study, folder, computation, executor, retry=retry, progress=progress)
    work_through(work, slots)
    return work.records


class _Cases:
    """The cases of a study that are left to do, and the records of the others."""

    def __init__(
        self,
        study: Study,
        folder: Path,
        computation: Computation,
        executor: Executor,
        *,
        retry: bool,
        progress: Callable[[StudyProgress], None] | None,
    ) -> None:
        self._study, self._folder, self._computation = study, folder, computation
        self._executor, self._progress = executor, progress
        self._store = Store(folder, computation.settings)
        self._tries: Counter[tuple[int, ...]] = Counter()
        self._finished: list[Case] = []
        self.pending: list[Case] = []
        self.records: dict[tuple[int, ...], CaseRecord] = {}
        for case in study.cases:
            self._store.tidy(case.train)
            record = self._store.record(case.train)
            if record is None or (retry and record.status == "failed"):
                self.pending.append(case)
            else:
                self._know(case, record)
        self._tell(())

    def take(self, running: Sequence[Case]) -> tuple[Case, "Future[CaseRecord]"]:
        """Give out a case."""
        case, start = choose(self._study, self.pending, self._finished, running)
        self.pending.remove(case)
        train = start.train if start else None
        arguments = (self._computation, self._folder, case.train, train)
        return case, self._executor.submit(compute_case, *arguments)

    def settle(self, case: Case, answer: CaseRecord | WorkerDied) -> None:
        """Keep the record of a case that has ended, or give it out again if its worker died."""
        self._tries[case.index] += 1
        if isinstance(answer, WorkerDied):
            if self._tries[case.index] < TRIES:
                self.pending.append(case)
                return
            answer = self._store.fail(case.train, answer.reason)
        self._know(case, answer)
        self._tell(((case, answer),))

    def _know(self, case: Case, record: CaseRecord) -> None:
        self.records[case.index] = record
        if record.status == "finished":
            self._finished.append(case)

    def _tell(self, ended: tuple[tuple[Case, CaseRecord], ...]) -> None:
        if self._progress is not None:
            ready = len(self._finished)
            failed = len(self.records) - ready
            self._progress(StudyProgress(ready, failed, len(self._study.cases), ended))


def choose(
    study: Study, pending: Sequence[Case], finished: Sequence[Case], running: Sequence[Case]
) -> tuple[Case, Case | None]:
    """The next case, and the finished one to start from, if any.

    It is the pending case nearest to a finished one; before any is finished, the one farthest from
    those that run, so that they spread.
    """
    if finished:
        _, case, start = min(
            ((study.distance(one, other), one, other) for one in pending for other in finished),
            key=lambda each: each[0],
        )
        return case, start
    if not running:
        return pending[0], None
    return (
        max(pending, key=lambda one: min(study.distance(one, other) for other in running)),
        None,
    )
