"""Work that is given out to any executor, one job for each of its slots at a time.

What is given out next is decided as late as possible. A worker that dies takes no other job with
it; a scheduler that is lost ends everything.
"""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from dataclasses import dataclass
from typing import Protocol, TypeVar

from celltrain.study.definition import Case

#: How often a case is tried whose worker dies, before it counts as failed.
TRIES = 2
# Seconds after which to look for new slots while no job ends.
LOOK_AGAIN = 2.0

Job = TypeVar("Job")
Answer = TypeVar("Answer")
Found = TypeVar("Found")


class NotKept(RuntimeError):
    """A case's result could not be written. What was written before is kept."""


class WorkersLost(RuntimeError):
    """Nothing computes any more: the scheduler has gone. What is finished is kept."""


class Ended(Protocol):
    """What is told of a case that has ended."""

    @property
    def status(self) -> str:
        """Whether it is finished or failed."""

    @property
    def reason(self) -> str:
        """Why it failed."""

    @property
    def values(self) -> Mapping[str, float | None]:
        """Its numbers by name."""


@dataclass(frozen=True)
class StudyProgress:
    """Where the run of a study stands; `ended` are the cases that have just ended."""

    finished: int
    failed: int
    total: int
    ended: Sequence[tuple[Case, Ended]] = ()


@dataclass(frozen=True)
class WorkerDied:
    """The end of the process that had a job, which may have had nothing to do with it."""

    reason: str


class Queue(Protocol[Job, Answer]):
    """Jobs that are left to do, and what becomes of those that are done."""

    @property
    def pending(self) -> Sequence[object]:
        """What is left to give out."""

    def take(self, running: Sequence[Job]) -> "tuple[Job, Future[Answer]]":
        """Give out the next job while others run."""

    def settle(self, job: Job, answer: Answer | WorkerDied) -> None:
        """Keep an answer; a job without one may become pending again."""


def work_through(queue: Queue[Job, Answer], slots: Callable[[], int]) -> None:
    """Do all work; `slots` says how many jobs may run at a time.

    **Raises:** `WorkersLost` if the executor gives up; `NotKept` as a job does.
    """
    running: dict[Future[Answer], Job] = {}
    while queue.pending or running:
        while queue.pending and len(running) < max(1, slots()):
            job, future = queue.take(list(running.values()))
            running[future] = job
        done, _ = wait(running, timeout=LOOK_AGAIN, return_when=FIRST_COMPLETED)
        for future in done:
            answer = answer_of(future)
            queue.settle(running.pop(future), answer)


def answer_of(future: "Future[Found]") -> Found | WorkerDied:
    """What a job gave, or that its worker died.

    **Raises:** `WorkersLost`, `NotKept`.
    """
    try:
        return future.result()
    except NotKept:
        raise
    except CancelledError:
        raise WorkersLost("the scheduler of the workers was lost") from None
    except Exception as error:
        # A job that fails says so itself.
        return WorkerDied(f"its worker died in {TRIES} tries ({type(error).__name__}): {error}")
