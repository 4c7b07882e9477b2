"""The paper's 32 statements: what holds, at which resolution, and why not where it does not."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from celltrain.paper import explained_curves as curves
from celltrain.paper import explained_maps as maps
from celltrain.paper.comparison import (
    FAILS,
    FAILS_AT_PAPER,
    HOLDS,
    HOLDS_AT_PAPER,
    ONLY_CONVERGED,
    ONLY_PAPER,
    UNKNOWN,
    Compared,
)
from celltrain.paper.evidence import Evidence, all_parts
from celltrain.paper.explanation import Explanation
from celltrain.paper.finding import Finding


@dataclass(frozen=True)
class Statement:
    """A statement: its name, its place in the paper, and what it says in our words."""

    name: str
    where: str
    claim: str
    explain: Callable[[Evidence], Explanation] | None = None


STATEMENTS = (
    Statement("P1", "V A, Fig. 5", "base flows are bullets, converged to 1e-4 U"),
    Statement("P2", "III", "U/U^ in 1.244 to 1.256 over all cases", maps.box),
    Statement(
        "P3",
        "III, V",
        "M = 16 changes alpha by 1 %, twice Ed by less than 2 %, twice N by less than 1 %",
        maps.degree,
    ),
    Statement("P4", "Fig. 3", "N = 2, lam = 5: three growing eigenvalues, most far negative"),
    Statement("P5", "Fig. 4", "v_eta follows exp(A t), below v_alpha by t = 0.2"),
    Statement("P6", "Fig. 6", "phi = 0.2: alpha about 0.1, smaller for larger D", maps.sparse_map),
    Statement("P7", "Fig. 6", "phi = 0.7: alpha about 0.1 for all D", maps.dense_map),
    Statement("P8", "Fig. 6", "D <= 10, phi = 0.4 to 0.55: alpha < 1e-3", maps.valley),
    Statement(
        "P9", "Fig. 6b", "phi = 0.2: all cells tilt alike; 0.7: two cells a wave", maps.waves
    ),
    Statement("P10", "Fig. 7", "recirculation joins, stagnates, is small as phi rises", maps.flow),
    Statement("P11", "Fig. 8", "eta varies by about 4, rising with D and phi", maps.initial),
    Statement("P12", "Fig. 8b", "v_eta: waves of two and of four cells", maps.patterns),
    Statement("P13", "V B 2", "eta independent of N; tenfold after 0.4 D; gone by D", maps.early),
    Statement("P14", "Fig. 9", "eps = 0.1 in v_eta leads to no nonlinear growth"),
    Statement("P15", "Fig. 10", "the spectrum of v_alpha decays faster than that of v_eta"),
    Statement(
        "P16",
        "Fig. 11",
        "theory holds until eps_x = 0.5 and 5; ad hoc takes 2.7 and 4.3 times longer",
        maps.ad_hoc,
    ),
    Statement("P17", "Fig. 12", "rotation by t = 61, breakup by 97"),
    Statement("P18", "Fig. 1", "N = 8 stays in order, N = 12 breaks up"),
    Statement("P19", "Fig. 13a", "eta halves from lam = 1 to 5", curves.halving),
    Statement("P20", "Fig. 13b", "alpha about 4 times larger at lam = 5, dense", curves.viscosity),
    Statement("P21", "Fig. 14", "phi = 0.2: + 10 % to lam = 20, then a plateau", curves.viscosity),
    Statement("P22", "Fig. 14", "phi = 0.7: lam about 1 most stable, plateau", curves.viscosity),
    Statement(
        "P23", "Fig. 14", "tumbling rises with lam; tank-treading as it falls", curves.turning
    ),
    Statement("P24", "Fig. 16a", "phi = 0.2: alpha halves from Ca = 1 to 10", curves.strength),
    Statement(
        "P25", "Fig. 16b", "phi = 0.7: alpha rises with Ca as the gap falls", curves.dense_flow
    ),
    Statement("P26", "Fig. 17", "shapes for v = 0.4 to 1; repulsion below 0.61", curves.shapes),
    Statement("P27", "Fig. 19a", "phi = 0.2: most unstable v about 0.55, 0.52", curves.volume),
    Statement("P28", "Fig. 19b", "phi = 0.7: alpha rises with v; none above 0.86", curves.filled),
    Statement(
        "P29", "Fig. 20", "without nearest neighbours alpha falls, up to 1000-fold", curves.near
    ),
    Statement("P30", "Table I", "strain energies of four trains", curves.table),
    Statement(
        "P31", "V G", "all that grows at first has W > 0.6, mostly dilatation", curves.energies
    ),
    Statement(
        "P32", "VI", "phi = 0.4 to 0.6, D <= 10: 1e5 r0 before growing 1e3-fold", maps.valley
    ),
)


@dataclass(frozen=True)
class Verdict:
    """What is said of a statement: its parts, what the paper's solver gives, and the verdict."""

    statement: Statement
    parts: tuple[Compared, ...]
    solver: str
    verdict: str


def verdicts(evidence: Evidence) -> list[Verdict]:
    """All statements in order.

    Raises:
        ValueError: if a statement has no part.
    """
    parts = all_parts(evidence)
    found = []
    for statement in STATEMENTS:
        own = tuple(each for each in parts if each.name == statement.name)
        if not own:
            raise ValueError(f"nothing is kept on {statement.name}")
        explained = (
            Explanation("", "", shown=False)
            if statement.explain is None
            else statement.explain(evidence)
        )
        found.append(Verdict(statement, own, explained.solver, _words(own, explained)))
    return found


def _words(parts: Sequence[Compared], explained: Explanation) -> str:
    kinds = [each.verdict for each in parts]
    if set(kinds) == {HOLDS}:
        return HOLDS
    order = (HOLDS, ONLY_PAPER, ONLY_CONVERGED, FAILS, HOLDS_AT_PAPER, FAILS_AT_PAPER, UNKNOWN)
    counts = {kind: kinds.count(kind) for kind in order}
    if len(parts) == 1 or len(set(kinds)) == 1:
        first = kinds[0]
    else:
        listed = [f"{kind} ({count})" for kind, count in counts.items() if count]
        first = f"{len(parts)} parts, " + ", ".join(listed)
    if not explained.reason:
        return f"{first}: why is open"
    return f"{first}: {'' if explained.shown else 'why is open; '}{explained.reason}"


def verdicts_table(found: Sequence[Verdict]) -> str:
    """The verdicts as a table in Markdown, a line for each statement."""
    lines = [
        "| | where | the paper, in our words | at M = 12 | converged | the paper's solver |"
        " verdict |",
        "|---|---|---|---|---|---|---|",
    ]
    for each in found:
        cells = (
            each.statement.name,
            each.statement.where,
            each.statement.claim,
            _side([part.paper for part in each.parts]),
            _side([part.converged for part in each.parts]),
            each.solver or "not run",
            each.verdict,
        )
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def _side(found: Sequence[Finding | None]) -> str:
    """How many parts hold at one resolution, and the numbers of the first that does not."""
    known = [each for each in found if each is not None]
    if not known:
        return "not simulated"
    if all(each.holds is None for each in known):
        return "not computed"
    holding = sum(each.holds is True for each in known)
    if holding == len(known):
        return f"yes ({known[0].found})"
    count = "no" if holding == 0 else f"{holding} of {len(known)}"
    failing = next((each for each in known if each.holds is False), known[0])
    return f"{count} ({failing.found})"
