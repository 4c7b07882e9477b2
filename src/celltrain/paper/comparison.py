"""The paper's statements at both resolutions beside each other, and what follows."""

from collections.abc import Sequence
from dataclasses import dataclass

from celltrain.paper.finding import Finding

HOLDS = "holds"
ONLY_PAPER = "holds at M = 12 only"
ONLY_CONVERGED = "holds converged, not at M = 12"
FAILS = "does not hold"
UNKNOWN = "not known"
#: Where cases that the statement needs are not there converged.
HOLDS_AT_PAPER, FAILS_AT_PAPER = (
    "holds at M = 12, not computed converged",
    ("does not hold at M = 12, not computed converged"),
)


@dataclass(frozen=True)
class Compared:
    """A part of a statement: what is found at the paper's degree, and converged.

    Either may be absent: what has no degree, or was found at one of them only.
    """

    name: str
    statement: str
    paper: Finding | None
    converged: Finding | None

    @property
    def verdict(self) -> str:
        """What both say."""
        known = [each.holds for each in (self.paper, self.converged) if each is not None]
        if len(known) == 2 and known[0] is not None and known[1] is None:
            return HOLDS_AT_PAPER if known[0] else FAILS_AT_PAPER
        if not known or None in known:
            return UNKNOWN
        if all(known):
            return HOLDS
        if not any(known):
            return FAILS
        assert self.paper is not None
        return ONLY_PAPER if self.paper.holds else ONLY_CONVERGED


def compared(paper: Sequence[Finding], converged: Sequence[Finding]) -> list[Compared]:
    """Findings of one figure at both resolutions, which have the same statements in order.

    Raises:
        ValueError: if they do not.
    """
    if not paper or not converged:
        return [
            Compared(each.name, each.statement, each if paper else None, None if paper else each)
            for each in paper or converged
        ]
    return [
        Compared(one.name, one.statement, one, other)
        for one, other in zip(paper, converged, strict=True)
        if _same(one, other)
    ]


def comparison_table(parts: Sequence[Compared]) -> str:
    """Parts as a table in Markdown."""
    lines = [
        "| | the paper, in our words | M = 12 | converged | verdict |",
        "|---|---|---|---|---|",
    ]
    lines += [
        f"| {each.name} | {each.statement} | {_found(each.paper)} | {_found(each.converged)} |"
        f" {each.verdict} |"
        for each in parts
    ]
    return "\n".join(lines) + "\n"


def _found(found: Finding | None) -> str:
    if found is None:
        return ""
    words = {True: "yes", False: "no", None: "not known"}
    return f"{words[found.holds]}: {found.found}"


def _same(one: Finding, other: Finding) -> bool:
    if (one.name, one.statement) != (other.name, other.statement):
        raise ValueError(f"{one.statement!r} is beside {other.statement!r}")
    return True
