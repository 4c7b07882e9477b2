"""docs/paper.md: the paper's figures, statements and equations beside ours, from kept data."""

from figures import made_with
from page import FOLDER, Page

from celltrain.paper import checks
from celltrain.paper.comparison import FAILS, HOLDS
from celltrain.paper.equations import equations_table
from celltrain.paper.evidence import CHECKS, ENDINGS, read_evidence
from celltrain.paper.resolutions import CONVERGED, PAPER
from celltrain.paper.trains import PAPER_DEGREE
from celltrain.paper.verdicts import Verdict, verdicts, verdicts_table
from celltrain.results import write_dataset

#: What the paper shows: what, the page, and the command.
FIGURES = (
    ("Fig. 1", "eight and twelve cells in the same tube", "breakup", "eight twelve"),
    ("Fig. 2", "the model", "../method", None),
    ("Fig. 3", "spectrum of two cells, viscosity ratio 5", "figures", "fig3"),
    ("Fig. 4", "growth of v_alpha and v_eta, small", "figures", "fig4"),
    ("Figs. 5, 15, 18", "steady trains", "figures", "fig5"),
    ("Fig. 6", "alpha over diameter and packing", "figures", "fig6"),
    ("Fig. 7", "streamlines between cells", "figures", "fig7"),
    ("Fig. 8", "eta over diameter and packing", "figures", "fig8"),
    ("Fig. 9", "v_alpha and v_eta of a tenth of r0", "figures", "fig9"),
    ("Fig. 10", "spectra of v_alpha and v_eta", "figures", "fig10"),
    ("Fig. 11", "growth of the mode and of displaced cells", "figures", "fig11"),
    ("Figs. 11, 12", "breakup, simulated", "breakup", "leading random sparse"),
    ("Fig. 13", "viscosity ratio and packing", "figures", "fig13"),
    ("Fig. 14", "viscosity ratio", "figures", "fig14"),
    ("Fig. 16", "capillary number", "figures", "fig16"),
    ("Fig. 17", "cells at rest of any reduced volume", "figures", "fig17"),
    ("Fig. 19", "reduced volume", "figures", "fig19"),
    ("Fig. 20", "growth without near neighbours", "figures", "fig20"),
    ("Table I", "strain energy of disturbances", "figures", "table1"),
)
#: Where files of the package are, seen from the page.
SOURCE = "../src/celltrain"


def study() -> None:
    page = Page("paper", "The paper, beside ours", FOLDER.parent)
    _make_checks(page)
    evidence = read_evidence(FOLDER)
    found = verdicts(evidence)
    page.log("verdicts")
    page.text(
        f"""
*Bryngelson & Freund 2018* figure by figure and statement by statement: what it says, what we find
at its resolution (M = {PAPER_DEGREE}) and converged, what its own solver gives where that was run,
and why they differ where they do. Made from the data in `validation/data`, by code that the tests
run. Rates and times: [the units of the
paper](../README.md#units-and-two-inconsistencies-of-the-paper), U*/r0 with U* = U/10.
"""
    )
    page.heading("Figures and tables")
    page.text(
        """
`celltrain paper FIGURE` computes and draws a figure converged, `--resolution paper` at M = 12;
where both have been computed the picture shows both. They take minutes on two cores, Fig. 16
converged a third of an hour, for dense trains in strong flow; [growth rates over the
degree](validation/disputed.md) has more degrees. What is simulated takes hours, and has a command
of its own. All pages together but simulations, from nothing, take less than [two
hours](validation.md).
"""
    )
    page.table(("paper", "what", "page", "command"), [_row(*each) for each in FIGURES])
    page.heading("Statements")
    page.text(_summary(found))
    page.text(
        """
A statement has one or more parts, which are listed with their numbers on [the page of the
figures](validation/figures.md); here are how many hold and, in brackets, what was found of the
first that does not, or of the first. More: [growth rates over the degree](validation/disputed.md)
and over [the map](validation/map.md), [the two eigenvalues of Fig. 16](validation/double_point.md),
[initial growth in every norm](validation/initial_growth.md), [the ad hoc
disturbance](validation/ad_hoc.md), [simulations at first](validation/transients.md) and [of
breakup](validation/breakup.md).
"""
    )
    page.parts.append(verdicts_table(found).rstrip())
    page.text(f"The paper's solver: {evidence.solver['source']}")
    _authors(page)
    page.heading("Equations")
    page.parts.append(equations_table(SOURCE).rstrip())
    page.write()


def _make_checks(page: Page) -> None:
    """The numbers of P2 and P3, unless they are kept."""
    for resolution, degree in ((PAPER, PAPER_DEGREE), (CONVERGED, None)):
        path = FOLDER / "data" / f"{CHECKS}{ENDINGS[resolution]}.nc"
        if not path.is_file():
            write_dataset(made_with(checks.compute(degree)), path)
            page.log(f"checks, {resolution}")


def _row(paper: str, words: str, page: str, command: str | None) -> tuple[str, ...]:
    link = "[method](method.md)" if page.startswith("..") else f"[{page}](validation/{page}.md)"
    if command is None:
        return paper, words, link, ""
    if page == "breakup":
        return paper, words, link, f"`python validation/run.py breakup --simulate {command}`"
    return paper, words, link, f"`celltrain paper {command}`"


def _summary(found: list[Verdict]) -> str:
    whole = [each.statement.name for each in found if each.verdict == HOLDS]
    none = [
        each.statement.name for each in found if all(part.verdict == FAILS for part in each.parts)
    ]
    unclear = [each.statement.name for each in found if "why is open" in each.verdict]
    return (
        f"Of {len(found)} statements {len(whole)} hold at both resolutions: {', '.join(whole)}."
        f" Of {len(none)} no part holds: {', '.join(none)}. The others hold in part. Why"
        f" {', '.join(unclear)} differ is open; what was tried stands with them."
    )


def _authors(page: Page) -> None:
    page.heading("What we would tell the authors")
    for text in (
        """
**The unit of rates.** At the paper's own parameters its own solver gives alpha = 0.018 U/r0 where
0.16 U/r0 is printed (D = 8, packing 0.2). All rates and times that are printed are in U* = U/10,
the unit of velocity of the code: alpha, eta, times to breakup, and, read so, the energies of Table
I.
""",
        """
**The capillary number.** mu U/Es is 0.82 with the velocity in the tube; 0.66 takes the mean
velocity of the box, and so does the axis of Fig. 16.
""",
        """
**The degree.** M = 12 is not converged to 1 % but to some 5 % in sparse trains, and to no figure
near the neutral curve or in strong flow: its own solver changes alpha by 6 % from M = 12 to 16.
There the two codes, which share nothing, come to the same growth rates from opposite sides. Fig.
16(a) turns on it: two real eigenvalues meet near Ca = 3 and grow hardly, as a complex pair, beyond.
""",
        """
**The double layer.** A steady train moves rigidly, so K v = -v/2 on every cell whatever its shape,
and nothing steady depends on the viscosity ratio. The discrete K misses this by 1.5e-3 at M = 12,
which moves the train and multiplies its growth rate by more than five at a ratio of 5 (D = 12,
packing 0.7). With the identity imposed the factor is gone. So Figs. 13(b) and 14 show an error in
proportion to lam - 1, and "a ratio of about 1 is the most stable" with them.
""",
        """
**The bending moments.** The published solver leaves out the in-plane stress that balances the
moments about the normal ("to be added"): its membrane turns the fluid. That is not why the growth
rates differ: at D = 8, packing 0.2, M = 12, alpha is 0.01597 with its law, 0.01641 with the
balance, and 0.01659 with the energy (`bending = "moments"`, `"balanced_moments"`, `"elastic"`). An
energy by Eq. (23) does not belong to moments by Eq. (2).
""",
        """
**The norm.** eta and v_eta depend on how the norm of Eq. (8) counts the harmonics of order 0, and
need a higher degree than alpha; state both.
""",
    ):
        page.text(text)
