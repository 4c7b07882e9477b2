"""The run of a study of distributions: the central train, its neighbours, then all others.

The trains of a point go to a worker together, as some of them share a cell and its shape at rest;
whoever runs the study keeps their numbers when they arrive.
"""

from collections import Counter, deque
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from celltrain.harmonics import Profile
from celltrain.parameters import CaseError, Train
from celltrain.results import only_writer
from celltrain.steady import Base
from celltrain.study.computation import StabilityOfCase
from celltrain.study.definition import Case, Computed, Study
from celltrain.study.dispatch import TRIES, NotKept, StudyProgress, WorkerDied, work_through
from celltrain.study.engine import run_study
from celltrain.study.sampling.definition import DrawnTrain, SampledStudy
from celltrain.study.sampling.draws import (
    STEP,
    DrawJob,
    DrawRecord,
    Guess,
    make_guess,
    neighbour,
)
from celltrain.study.sampling.store import DrawStore, draw_store
from celltrain.study.store import CaseRecord, Store

DrawRecords = dict[tuple[int, ...], DrawRecord]
Tell = Callable[[StudyProgress], None]


class NoCentralTrain(RuntimeError):
    """The train of the means was not found, from which all others are sought."""


@dataclass(frozen=True)
class Sampled:
    """What came of a sample: the records by the draws' indices, and that of the central train."""

    central: CaseRecord
    records: DrawRecords


def run_sample(
    study: SampledStudy,
    folder: Path,
    executor: Executor,
    slots: Callable[[], int],
    *,
    retry: bool = False,
    progress: Tell | None = None,
) -> Sampled:
    """Compute the trains of a sample that the folder has no numbers of.

    **Arguments:** as `run_study`.

    **Raises:** `NoCentralTrain`; otherwise as `run_study`.
    """
    with only_writer(folder):
        alone = Study(study.title, (), Computed(), (Case((), {}, study.central),), study.units)
        computation = StabilityOfCase(alone.computed)
        central = run_study(alone, folder, computation, executor, slots, retry=retry)[()]
        if central.status == "failed":
            raise NoCentralTrain(
                "the train of the means, from which all others are sought, failed:"
                f" {central.reason}"
            )
        base = Store(folder, computation.settings).base(study.central)
        # That of the central train's fastest mode is looked at, whatever was asked for.
        leading = int(central.values["leading_azimuthal_number"] or 0)
        settings = {
            "kind": "sample",
            "central": central.address,
            "azimuthal_numbers": sorted({*study.computed.azimuthal_numbers, leading}),
        }
        with draw_store(folder, settings) as store:
            work = _Points(study, base, store, executor, settings, retry=retry, tell=progress)
            if work.pending:
                work.guess = _guess(study, base, executor, slots)
                work_through(work, slots)
        return Sampled(central, work.records)


class _Points:
    """The trains that are left to do, point by point, and the records of the others."""

    def __init__(
        self,
        study: SampledStudy,
        base: Base,
        store: DrawStore,
        executor: Executor,
        settings: dict[str, Any],
        *,
        retry: bool,
        tell: Tell | None,
    ) -> None:
        self._total, self._degree, self._store = study.total, base.train.degree, store
        self._executor, self._told = executor, tell
        self._numbers = tuple(settings["azimuthal_numbers"])
        self._tries: Counter[tuple[int, ...]] = Counter()
        self._failed = 0
        self.guess: Guess | None = None
        self.pending: deque[tuple[DrawnTrain, ...]] = deque()
        self.records: DrawRecords = {}
        known = store.records()
        for point in study.points:
            left = []
            for draw in point:
                record = known.get(self._address(draw))
                if record is None or (retry and record.status == "failed"):
                    left.append(draw)
                else:
                    self._know(draw, record)
            if left:
                self.pending.append(tuple(left))
        self._tell(())

    def take(
        self, running: Sequence[tuple[DrawnTrain, ...]]
    ) -> "tuple[tuple[DrawnTrain, ...], Future[list[DrawRecord]]]":
        """Give out the trains of a point."""
        del running
        assert self.guess is not None
        draws = self.pending.popleft()
        job = DrawJob(
            tuple(self._train(draw) for draw in draws),
            tuple(draw.scores for draw in draws),
            tuple(draw.checked for draw in draws),
            self._numbers,
        )
        return draws, self._executor.submit(job, self.guess)

    def settle(
        self, draws: tuple[DrawnTrain, ...], answer: "list[DrawRecord] | WorkerDied"
    ) -> None:
        """Keep what came of them; those of a worker that died are given out again one by one."""
        ended: list[tuple[DrawnTrain, DrawRecord]] = []
        if isinstance(answer, WorkerDied):
            for draw in draws:
                self._tries[draw.index] += 1
                if self._tries[draw.index] < TRIES:
                    self.pending.append((draw,))
                else:
                    ended.append((draw, DrawRecord("failed", answer.reason, {})))
        else:
            ended += zip(draws, answer, strict=True)
        if not ended:
            return
        try:
            self._store.add({self._address(draw): record for draw, record in ended})
        except OSError as error:
            raise NotKept(str(error)) from None
        for draw, record in ended:
            self._know(draw, record)
        self._tell(ended)

    def _train(self, draw: DrawnTrain) -> Train:
        return draw.train.resolved(self._degree)

    def _address(self, draw: DrawnTrain) -> str:
        return self._store.address(self._train(draw), checked=draw.checked)

    def _know(self, draw: DrawnTrain, record: DrawRecord) -> None:
        self.records[draw.index] = record
        self._failed += record.status == "failed"

    def _tell(self, ended: Sequence[tuple[DrawnTrain, DrawRecord]]) -> None:
        if self._told is not None:
            ready = len(self.records) - self._failed
            self._told(StudyProgress(ready, self._failed, self._total, ended))


def _guess(study: SampledStudy, base: Base, executor: Executor, slots: Callable[[], int]) -> Guess:
    """From the central train and its neighbours along each parameter."""
    work = _Neighbours(study, base, executor)
    work_through(work, slots)
    found = work.found
    return make_guess(
        base, [(found.get((i, -1)), found.get((i, 1))) for i in range(len(study.names))]
    )


class _Neighbours:
    """The neighbours of the central train; one that is not found is missing."""

    def __init__(self, study: SampledStudy, base: Base, executor: Executor) -> None:
        self._executor, self._base = executor, base
        self.found: dict[tuple[int, int], Profile | None] = {}
        self.pending: list[tuple[tuple[int, int], Train]] = []
        for i in range(len(study.names)):
            for side in (-1, 1):
                try:
                    train = study.neighbour(i, side * STEP).resolved(base.train.degree)
                except CaseError:
                    continue
                self.pending.append(((i, side), train))

    def take(self, running: Sequence[tuple[int, int]]) -> "tuple[tuple[int, int], Future[Any]]":
        """Give out a neighbour."""
        del running
        place, train = self.pending.pop(0)
        return place, self._executor.submit(neighbour, train, self._base)

    def settle(self, place: tuple[int, int], answer: Profile | WorkerDied | None) -> None:
        """Keep a neighbour."""
        self.found[place] = None if isinstance(answer, WorkerDied) else answer
