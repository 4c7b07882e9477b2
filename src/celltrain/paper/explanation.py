"""Why a statement of the paper does not hold, as far as the kept data show it."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Explanation:
    """What the paper's solver gives, the reason or what was tried, and whether it is shown."""

    solver: str
    reason: str
    shown: bool
