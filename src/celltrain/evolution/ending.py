"""Why a simulation ended."""

from dataclasses import dataclass
from typing import Annotated, Literal

from celltrain.quantities import Quantity

EndingKind = Literal[
    "running",
    "complete",
    "steps",
    "interrupted",
    "not_finite",
    "step_too_small",
    "overlap",
    "near_wall",
    "not_saved",
    "failed",
]


@dataclass(frozen=True)
class Ending:
    """Why a simulation ended, as a word and a sentence; "running" as long as it has not.

    "complete": the time asked for is reached; "steps": as many steps as asked for are taken;
    "interrupted": by the user; "not_finite": velocities are NaN; "step_too_small"; "overlap"
    of cells or of a cell and the wall; "near_wall": a cell so close to it that the wall cannot be
    resolved; "not_saved": the file could not be written; "failed": the
    velocity could not be computed. All but the first can be gone on from, if the reason is gone.
    """

    kind: Annotated[EndingKind, Quantity("", "1", "why it ended")]
    message: Annotated[str, Quantity("", "1", "the same in words")]

    @property
    def failed(self) -> bool:
        """Whether the simulation could not go on."""
        return self.kind not in ("running", "complete", "steps", "interrupted")


class StepFailed(RuntimeError):
    """No step can be taken from a state; why as a word (see `Ending`) and as a sentence.

    `rejected` and `evaluations` say what was tried in vain.
    """

    def __init__(
        self, kind: EndingKind, message: str, *, rejected: int = 0, evaluations: int = 0
    ) -> None:
        super().__init__(message)
        self.kind = kind
        self.rejected, self.evaluations = rejected, evaluations
