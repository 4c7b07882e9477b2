"""The kept data of the paper's figures: verdicts, pictures, the page, and the paper's solver."""

import importlib
import tomllib
from pathlib import Path

import numpy as np
import pytest
from drawn import labels, words_outside

from celltrain import Train, stability, steady
from celltrain.paper import FIGURES
from celltrain.paper.comparison import (
    FAILS,
    FAILS_AT_PAPER,
    HOLDS,
    HOLDS_AT_PAPER,
    ONLY_CONVERGED,
    ONLY_PAPER,
    UNKNOWN,
    Compared,
    compared,
)
from celltrain.paper.equations import EQUATIONS, equations_table
from celltrain.paper.evidence import Evidence, all_parts, read_evidence
from celltrain.paper.finding import Finding
from celltrain.paper.resolutions import CONVERGED, PAPER
from celltrain.paper.verdicts import STATEMENTS, verdicts, verdicts_table

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"


@pytest.fixture(scope="module")
def evidence() -> Evidence:
    return read_evidence(DOCS / "validation")


def test_every_statement_has_a_verdict_with_its_numbers(evidence: Evidence) -> None:
    found = verdicts(evidence)
    assert [each.statement.name for each in found] == [f"P{number}" for number in range(1, 33)]
    for each in found:
        kinds = {part.verdict for part in each.parts}
        # What holds altogether is said to hold; everything else is explained, or called open.
        assert (kinds == {HOLDS}) == (each.verdict == HOLDS)
        assert UNKNOWN not in kinds, each.statement.name
        if kinds != {HOLDS}:
            assert ": " in each.verdict
            assert len(each.verdict.split(": ", 1)[1]) > 40
    assert {part.name for part in all_parts(evidence)} == {each.name for each in STATEMENTS}


def test_the_page_shows_these_verdicts_and_equations(evidence: Evidence) -> None:
    page = (DOCS / "paper.md").read_text()
    assert verdicts_table(verdicts(evidence)).rstrip() in page
    assert equations_table("../src/celltrain").rstrip() in page


def test_every_equation_is_somewhere() -> None:
    numbers: list[int] = []
    for each in EQUATIONS:
        parts = each.numbers.replace(" to ", "-").split(", ")
        for part in parts:
            first, _, last = part.partition("-")
            numbers += range(int(first), int(last or first) + 1)
        for name in each.names:
            _resolved(name)
    assert sorted(numbers) == list(range(1, 25))
    for link in equations_table(str(ROOT / "src/celltrain")).split("](")[1:]:
        assert Path(link.split(")")[0]).is_file()


def _resolved(name: str) -> object:
    parts = name.split(".")
    for count in range(len(parts) - 1, 0, -1):
        try:
            found: object = importlib.import_module(".".join(parts[:count]))
        except ModuleNotFoundError:
            continue
        for part in parts[count:]:
            found = getattr(found, part)
        return found
    raise AssertionError(name)


@pytest.mark.parametrize("name", FIGURES)
def test_pictures_show_both_resolutions_and_all_of_their_words(
    name: str, evidence: Evidence
) -> None:
    figure = FIGURES[name]
    data = evidence.studies[figure.study]
    picture = figure.draw(data)
    assert words_outside(picture) == []
    if name not in ("fig5", "fig7", "fig17", "fig20"):
        assert any("M = 12" in each for each in labels(picture)), labels(picture)
    assert words_outside(figure.draw({PAPER: data[PAPER]})) == []


def test_equal_quantities_have_equal_labels(evidence: Evidence) -> None:
    def axes_of(name: str) -> set[str]:
        figure = FIGURES[name]
        data = evidence.studies[figure.study]
        return labels(figure.draw(data))

    for name in ("fig13", "fig14", "fig16", "fig19"):
        assert r"$\alpha\, r_0/U^*$" in axes_of(name)
    for name in ("fig6", "fig8", "fig13"):
        assert r"$\phi$" in axes_of(name)


def test_curves_are_the_data(evidence: Evidence) -> None:
    data = evidence.studies["cell-volume"]
    figure = FIGURES["fig19"].draw(data)
    lines = [line.get_xydata() for line in figure.axes[0].lines]
    for resolution in (CONVERGED, PAPER):
        expected = 10.0 * data[resolution]["spectral_abscissa"].sel(diameter=8, packing=0.2)
        assert any(
            line.shape == (expected.size, 2)
            and np.allclose(line[:, 1], expected.values, rtol=1e-12, equal_nan=True)
            for line in map(np.asarray, lines)
        ), resolution
    # Error bars stand where the error is known.
    assert figure.axes[0].collections


def test_verdicts_of_two_resolutions() -> None:
    def one(holds: bool | None) -> Finding:
        return Finding("P1", "it is so", "found", holds)

    cases = {
        (True, True): HOLDS,
        (True, False): ONLY_PAPER,
        (False, True): ONLY_CONVERGED,
        (False, False): FAILS,
        (None, True): UNKNOWN,
        (True, None): HOLDS_AT_PAPER,
        (False, None): FAILS_AT_PAPER,
    }
    for (paper, converged), expected in cases.items():
        assert Compared("P1", "it is so", one(paper), one(converged)).verdict == expected
    assert compared([one(True)], [])[0].verdict == HOLDS
    with pytest.raises(ValueError, match="is beside"):
        compared([one(True)], [Finding("P1", "it is not", "found", True)])


def test_the_papers_solver_and_this_one_agree() -> None:
    """Two codes that share nothing, at M = 16: 0.4 % in alpha, 1e-5 in U_c with the same law."""
    solver = tomllib.loads((DOCS / "validation" / "data" / "paper-solver.toml").read_text())
    [own] = [
        each["eigenvalues"]
        for each in solver["flow_strength"]
        if (each["Ca"], each["degree"]) == (0.66, 16)
    ]
    alpha = {}
    for bending in ("elastic", "moments"):
        train = Train(diameter=8, packing=0.2, cells=1, degree=16, bending=bending)
        base = steady(train, estimate_error=False)
        alpha[bending] = stability(base, azimuthal_numbers=[1], estimate_error=False)
        kept = solver["trains"][f"velocity_16_{bending}"]
        assert base.cell_velocity == pytest.approx(kept, abs=1e-5)
        if bending == "moments":
            # With the digit to which it is kept.
            assert base.cell_velocity == pytest.approx(solver["trains"]["velocity_16"], abs=1.5e-5)
    assert alpha["elastic"].spectral_abscissa == pytest.approx(own[0][0], rel=4e-3)
    second = sorted(alpha["elastic"].eigenvalues[1][0].real)[-2]
    assert second == pytest.approx(own[1][0], rel=0.06)
