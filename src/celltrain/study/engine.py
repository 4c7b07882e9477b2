"""The run of a study: which case is computed when, from where, and what becomes of it.

Cases go to any executor, one for each of its slots at a time, so that where a case may start from
is decided as late as possible. Workers write their results themselves: what is finished outlives
whoever asked for it.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Executor, Future, wait
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from celltrain.parameters import Train
from celltrain.results import only_writer
from celltrain.steady import Base
from celltrain.study.computation import Computation, Outcome
from celltrain.study.definition import Case, Study
from celltrain.study.store import CaseRecord, Store

#: How often a case is tried whose worker dies, before it counts as failed.
TRIES = 2
# Seconds after which to look for new slots while no case ends.
LOOK_AGAIN = 2.0


class NotKept(RuntimeError):
    """A case's result could not be written. What was written before is kept."""


class WorkersLost(RuntimeError):
    """Nothing computes any more: the scheduler has gone. What is finished is kept."""


@dataclass(frozen=True)
class StudyProgress:
    """Where the run of a study stands; `last` is the case that has just ended, if any."""

    finished: int
    failed: int
    running: int
    total: int
    last: tuple[Case, CaseRecord] | None = None


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
    store = Store(folder, computation.settings)
    records: dict[tuple[int, ...], CaseRecord] = {}
    pending: list[Case] = []
    for case in study.cases:
        store.tidy(case.train)
        record = store.record(case.train)
        if record is None or (retry and record.status == "failed"):
            pending.append(case)
        else:
            records[case.index] = record
    finished = [
        case
        for case in study.cases
        if case.index in records and records[case.index].status == "finished"
    ]
    running: dict[Future[CaseRecord], Case] = {}
    tries: Counter[tuple[int, ...]] = Counter()

    def tell(last: tuple[Case, CaseRecord] | None = None) -> None:
        if progress is not None:
            failed = sum(record.status == "failed" for record in records.values())
            ready = len(records) - failed
            progress(StudyProgress(ready, failed, len(running), len(study.cases), last))

    tell()
    while pending or running:
        while pending and len(running) < max(1, slots()):
            case, start = choose(study, pending, finished, list(running.values()))
            pending.remove(case)
            future = executor.submit(
                compute_case, computation, folder, case.train, start.train if start else None
            )
            running[future] = case
        done, _ = wait(running, timeout=LOOK_AGAIN, return_when=FIRST_COMPLETED)
        for future in done:
            case = running.pop(future)
            tries[case.index] += 1
            record = _settle(store, case, future, last=tries[case.index] >= TRIES)
            if record is None:
                pending.append(case)
                continue
            records[case.index] = record
            if record.status == "finished":
                finished.append(case)
            tell((case, record))
    return records


def _settle(
    store: Store, case: Case, future: "Future[CaseRecord]", *, last: bool
) -> CaseRecord | None:
    """The record of a case that has ended; None if its worker did, and this try is not the last."""
    try:
        return future.result()
    except NotKept:
        raise
    except CancelledError:
        raise WorkersLost("the scheduler of the workers was lost") from None
    except Exception as error:
        # A case that fails says so itself; this is the end of the process that computed it, which
        # may have had nothing to do with it.
        reason = f"its worker died in {TRIES} tries ({type(error).__name__}): {error}"
        return store.fail(case.train, reason) if last else None


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
