"""Why statements of the paper do not hold, as far as the kept data show it.

Each takes the evidence and says what the paper's own solver gives, what the reason is, and whether
the numbers show it; if not, what was tried.
"""

from dataclasses import dataclass

import numpy as np
import xarray as xr

from celltrain.paper.evidence import Evidence
from celltrain.paper.finding import at
from celltrain.paper.resolutions import CONVERGED, PAPER
from celltrain.parameters import paper_units

#: The valley of Fig. 6: packings, and the largest diameter.
VALLEY, WIDEST = (0.4, 0.55), 10.0
#: What a growth by a thousand is, and the paper's least distance to it, r0.
THOUSANDFOLD, DISTANCE = np.log(1e3), 1e5
#: Within what part two codes' growth rates agree.
AGREE = 0.3


@dataclass(frozen=True)
class Explanation:
    """What the paper's solver gives, the reason or what was tried, and whether it is shown."""

    solver: str
    reason: str
    shown: bool


def box(evidence: Evidence) -> Explanation:
    """P2."""
    ratios = evidence.studies["checks"][CONVERGED]["ratio"].values
    return Explanation(
        "",
        "a round impermeable wall in that box gives"
        f" {ratios.min():.3f} to {ratios.max():.3f}, {ratios.max() / 1.25 - 1.0:.0%} more at most;"
        " tried: the effective viscosity of our trains; not tried: its triangulated wall",
        shown=False,
    )


def degree(evidence: Evidence) -> Explanation:
    """P3: the solver's own change with the degree."""
    rates = {
        each["degree"]: each["eigenvalues"][0][0]
        for each in evidence.solver["flow_strength"]
        if each["Ca"] == 0.66
    }
    change = rates[16] / rates[12] - 1.0
    return Explanation(
        f"{rates[12]:.5f} at M = 12, {rates[16]:.5f} at 16: {change:+.0%} (D = 8, phi = 0.2)",
        "the paper's own solver changes by more than 1 % from M = 12 to 16; twice Ed matters in the"
        " narrow tube, and sixteen cells at packing 0.7 have waves that eight lack",
        shown=abs(change) > 0.02,
    )


def sparse_map(evidence: Evidence) -> Explanation:
    """P6."""
    alpha = _map(evidence, CONVERGED)
    peak = float(at(alpha, packing=0.2).idxmax("diameter"))
    return Explanation(
        _rate(evidence, 0.66, 16) + " at D = 8, M = 16",
        f"alpha is largest at D = {peak:g} and falls from there",
        shown=True,
    )


def dense_map(evidence: Evidence) -> Explanation:
    """P7: beside the solver's own rates of two cells."""
    own = {
        each["diameter"]: each["eigenvalue"][0]
        for each in evidence.solver["viscosity"]
        if each["packing"] == 0.7 and each["viscosity_ratio"] == 1.0
    }
    alpha = at(_map(evidence, CONVERGED), packing=0.7)
    ours = {diameter: float(at(alpha, diameter=diameter)) for diameter in own}
    agree = all(abs(own[each] / ours[each] - 1.0) < AGREE for each in own)
    listed = ", ".join(f"{paper_units.rate(own[each]):.3f} (D = {each:g})" for each in sorted(own))
    return Explanation(
        f"{listed}, two cells",
        "the paper's own solver agrees with ours, and the map's one colour tells no more",
        shown=agree,
    )


def valley(evidence: Evidence) -> Explanation:
    """P8, P32: alpha(M) of the trains of the valley."""
    inside = (
        (evidence.places[:, 0] <= WIDEST)
        & (evidence.places[:, 1] >= VALLEY[0] - 1e-9)
        & (evidence.places[:, 1] <= VALLEY[1] + 1e-9)
    )
    chosen = paper_units.rate(evidence.degrees[inside])
    low, high = (int((chosen[:, column] < 1e-3).sum()) for column in (0, -1))
    move = np.abs(chosen[:, -1] - chosen[:, -2]).max()
    worst = float(chosen[:, -1].max())
    distance = 1.9 * THOUSANDFOLD / paper_units.rate_from_paper(worst)
    return Explanation(
        "",
        f"below 1e-3 are {low} of {len(chosen)} trains at M = 12, {high} at M = 48, where alpha"
        f" is known to {move:.0e}; the largest, {worst:.3f}, grows a thousandfold in"
        f" {distance:.0e} r0;"
        " tried: degrees to 48, all azimuthal numbers; the valley is there, but is narrower",
        shown=False,
    )


def waves(evidence: Evidence) -> Explanation:
    """P9."""
    data = evidence.studies["map"][CONVERGED]
    wave = at(data["leading_wave_number"], packing=0.7)
    other = [float(each) for each in wave.diameter[wave.values != 4]]
    return Explanation(
        "",
        "at D = "
        + ", ".join(f"{each:g}" for each in other)
        + " the wave of 8/3 cells (j = 3) is a little faster than that of two (j = 4); both lie on"
        " one curve over the wave number",
        shown=bool(other),
    )


def flow(evidence: Evidence) -> Explanation:
    """P10."""
    strength = evidence.studies["streamlines"][CONVERGED]["strength"]
    return Explanation(
        "",
        "fluid that turns back at packing 0.6 and 0.7 is"
        f" {float(at(strength, packing=0.6)):.0e} and {float(at(strength, packing=0.7)):.0e} of"
        " what passes, at the limit of what is told from none (1e-4)",
        shown=True,
    )


def initial(evidence: Evidence) -> Explanation:
    """P11: eta over the degree and in other norms."""
    eta = evidence.initial["eta"]
    share = eta.sel(degree=12) / eta.isel(degree=-1)
    own = share.sel(norm="paper").values
    ranges = "; ".join(
        f"{name} {paper_units.rate(float(eta.sel(norm=name).isel(degree=-1).min())):.0f} to"
        f" {paper_units.rate(float(eta.sel(norm=name).isel(degree=-1).max())):.0f}"
        for name in ("paper", "orthonormal", "surface")
    )
    return Explanation(
        "",
        f"M = 12 has {own.min():.0%} to {own.max():.0%} of the converged eta, and eta depends on"
        f" the norm: {ranges} over the corners; in none does it rise with D at phi = 0.2",
        shown=bool(own.min() < 0.9),
    )


#: v_eta of the paper by corner (D, packing): whether axisymmetric, and cells a wave.
PATTERNS = ((False, 2), (False, 4), (False, 2), (True, 4))


def patterns(evidence: Evidence) -> Explanation:
    """P12: in which norm, and at which degree, the paper's patterns are found."""
    data = evidence.initial
    words, best = [], 0
    for norm in ("paper", "orthonormal", "surface"):
        counts = []
        for degree in (12, 48):
            here = data.sel(norm=norm, degree=degree)
            counts.append(_matching(here))
        best = max(best, *counts)
        words.append(f"{norm} {counts[0]} and {counts[1]}")
    return Explanation(
        "",
        "of the paper's four patterns are found at M = 12 and 48, by norm: "
        + "; ".join(words)
        + ". So the norm decides, and one that counts order 0 in full is nearest; the wave at"
        " D = 10, phi = 0.7 is axisymmetric there, but of eight cells",
        shown=best >= 3,
    )


def _matching(here: xr.Dataset) -> int:
    """How many of the corners have the paper's pattern."""
    count = 0
    for row, (axisymmetric, cells) in enumerate(PATTERNS):
        case = here.isel(case=row)
        wave = float(case["wave_number"])
        same = (float(case["azimuthal_number"]) == 0.0) == axisymmetric
        count += int(same and wave > 0 and 8.0 / wave == cells)
    return count


def early(evidence: Evidence) -> Explanation:
    """P13: how far exp(eta t) would have to be followed."""
    data = evidence.studies["initial-large"][CONVERGED]
    ways = data["way"].values * np.log(10.0) / data["numerical_abscissa"].values
    return Explanation(
        "",
        "exp(eta t) would be tenfold after "
        + " and ".join(f"{each:.2f} D" for each in ways)
        + f", but no disturbance follows it: {float(data['early'].max()):.1f} is the most by 0.4 D",
        shown=bool(data["early"].max() < 5.0),
    )


def ad_hoc(evidence: Evidence) -> Explanation:
    """P16: the assumptions that were tried."""
    factor = evidence.ad_hoc["factor"]
    tried = factor.sizes["disturbance"] * factor.sizes["size"]
    median = factor.isel(disturbance=0, size=0).median("seed")
    own = " and ".join(f"{float(median.sel(packing=each)):.2f}" for each in (0.2, 0.7))
    return Explanation(
        "",
        f"displaced cells take {own} times as long (phi = 0.2, 0.7) by the linear theory, which the"
        f" simulation follows; tried: {tried} assumptions on directions, the train's displacement,"
        " norms and amplitudes, none of which gives 4.3 and 2.7 ([ad hoc](validation/ad_hoc.md))",
        shown=False,
    )


def halving(evidence: Evidence) -> Explanation:
    """P19."""
    data = evidence.studies["viscosity-packing"][CONVERGED]["numerical_abscissa"]
    ratio = at(data, viscosity_ratio=5.0) / at(data, viscosity_ratio=1.0)
    sparse, dense = (at(ratio, packing=each) for each in (0.2, 0.7))
    return Explanation(
        "",
        f"half of it in dense trains ({float(dense.min()):.2f} to {float(dense.max()):.2f}) but not"
        f" in sparse ones ({float(sparse.min()):.2f} to {float(sparse.max()):.2f})",
        shown=True,
    )


def viscosity(evidence: Evidence) -> Explanation:
    """P20 to P22: the solver's double layer, with and without the identity of rigid motions."""
    rates = {
        (each["viscosity_ratio"], each["identity"]): each["eigenvalue"][0]
        for each in evidence.solver["viscosity"]
        if each["diameter"] == 12.0
    }
    one, five, identity = rates[1.0, False], rates[5.0, False], rates[5.0, True]
    ladder = _disputed(evidence, "viscosity_ratio", 5.0, 12.0, 0.7)
    return Explanation(
        f"lam = 5 over 1, D = 12, phi = 0.7: {five / one:.1f}; {identity / one:.2f} with the"
        " identity of rigid motions imposed on its matrices",
        "its double layer misses that identity (by 1.5e-3 at M = 12), which adds growth in"
        f" proportion to lam - 1; ours keeps it, and alpha at lam = 5 is {ladder[0]:.5f} U/r0 at"
        f" M = 12, {ladder[-1]:.5f} at 48",
        shown=five / one > 3.0 and identity / one < 1.2,
    )


def turning(evidence: Evidence) -> Explanation:
    """P23."""
    return Explanation(
        "",
        "it depends on the tube and the packing; where the leading wave changes with lam (two cells"
        " to 8/3) the rates jump; the solver's growth at lam above 1 is wrong as in P20",
        shown=viscosity(evidence).shown,
    )


def strength(evidence: Evidence) -> Explanation:
    """P24: two eigenvalues meet."""
    data = evidence.double_point
    fine = data.sel(degree=int(data["degree"][-1]))
    complex_ = float(abs(fine["imaginary"].sel(Ca=10.0)).max()) > 0.0
    own = {
        (each["Ca"], each["degree"]): each["eigenvalues"][0]
        for each in evidence.solver["flow_strength"]
    }
    fall = own[1.0, 12][0] / own[10.0, 12][0]
    at_four = own[4.0, 20]
    ladder = _disputed(evidence, "capillary_number", 10.0, 8.0, 0.2)
    return Explanation(
        f"M = 12: falls by {fall:.2f} from Ca = 1 to 10; M = 20, Ca = 4: {at_four[0]:.4f} +-"
        f" {abs(at_four[1]):.4f}i",
        "a truncation error: two real eigenvalues meet near Ca = 3 and are complex, hardly growing,"
        " beyond, which its solver finds at M = 20, too; ripples of m = 6 and 7 that lead from Ca ="
        f" 10 on at M = 12 (D = 8: {ladder[0]:.4f} U/r0) are gone at M = 48 ({ladder[-1]:.4f})",
        shown=complex_ and at_four[1] != 0.0 and fall > 1.4,
    )


def dense_flow(evidence: Evidence) -> Explanation:
    """P25."""
    data = evidence.studies["flow-strength"][CONVERGED]
    known = int(np.isfinite(at(data["spectral_abscissa"], packing=0.7)).sum())
    return Explanation(
        "",
        f"alpha falls up to Ca = 2, where it is known to 1 % ({known} of 16 dense trains were"
        " computed converged); tried: degrees to 48, all moduli in proportion; with Es alone"
        " divided there is an axisymmetric instability",
        shown=False,
    )


def shapes(evidence: Evidence) -> Explanation:
    """P26."""
    data = evidence.studies["shapes"][CONVERGED]
    return Explanation(
        "",
        f"without a repulsion the faces would meet below v = {float(data['contact']):.3f}; 0.61 is"
        " where one of 0.2 r0 begins to act",
        shown=True,
    )


def volume(evidence: Evidence) -> Explanation:
    """P27, P28: alpha over the volume at all degrees."""
    data = evidence.disputed
    chosen = data.isel(
        case=np.flatnonzero(
            (data["varied"] == "reduced_volume")
            & (data["diameter"] == 8.0)
            & np.isclose(data["packing"], 0.2)
        )
    )
    low, high = (
        float(chosen["value"].values[np.argmax(chosen["alpha"].sel(degree=each).values)])
        for each in (12, 48)
    )
    return Explanation(
        "",
        f"at phi = 0.2, D = 8 alpha is largest at v = {low:g} at M = 12 and at {high:g} at M = 48;"
        " tried: degrees to 48; not tried: the paper's shapes at rest, formed with its own"
        " repulsion",
        shown=False,
    )


def filled(evidence: Evidence) -> Explanation:
    """P28: the fullest cells at both ends of the degrees, and the flattest."""
    full = _disputed(evidence, "reduced_volume", 0.86, 8.0, 0.7)
    flat = [_disputed(evidence, "reduced_volume", each, 12.0, 0.7)[-1] for each in (0.4, 0.5)]
    return Explanation(
        "",
        f"at D = 8 alpha of the fullest cells (v = 0.86) is {full[0]:.5f} U/r0 at M = 12 but"
        f" {full[-1]:.5f} at 48, below that of v = 0.8; at D = 12 it falls at every degree from"
        f" {flat[0]:.5f} at v = 0.4 to {flat[1]:.5f} at 0.5; tried: degrees to 48; not tried: the"
        " paper's shapes at rest, formed with its own repulsion",
        shown=False,
    )


def near(evidence: Evidence) -> Explanation:
    """P29."""
    alpha = evidence.studies["interactions"][CONVERGED]["alpha"].sel(packing=0.7)
    stable = int((alpha.isel(removed=1) <= 0.0).sum())
    return Explanation(
        "",
        f"without its nearest neighbours {stable} of {alpha.sizes['cell']} dense trains are stable,"
        " so that the factor is any; a small number where ours is negative would be the paper's",
        shown=stable > 0,
    )


def table(evidence: Evidence) -> Explanation:
    """P30."""
    data = evidence.studies["strain"][CONVERGED]
    ours = np.abs(data["energy"].sel(disturbance="v_alpha").sum("part").values)
    factors = ours / data["printed"].values[:, 0]
    return Explanation(
        "",
        f"W_alpha, which has converged, is {factors.min():.1f} to {factors.max():.1f} times the"
        f" printed; tried: sums and means over the cells, mu U r0^2 and mu U* r0^2 (the one that"
        " fits best), degrees; W_eta: see P31",
        shown=False,
    )


def energies(evidence: Evidence) -> Explanation:
    """P31."""
    data = evidence.studies["strain"]
    low, high = (
        data[key]["energy"].sel(disturbance="v_eta").sum("part").values
        for key in (PAPER, CONVERGED)
    )
    growth = high / low
    least = [float(data[key]["least"].min()) for key in (PAPER, CONVERGED)]
    return Explanation(
        "",
        "v_eta is another disturbance at another degree, and depends on the norm: its W grows by"
        f" {growth.min():.1f} to {growth.max():.1f} from M = 12 to converged. Of all that grows at"
        f" first, m up to the degree, the least W is {least[0]:.2f} at M = 12 and {least[1]:.2f}"
        " converged, by the sum over the cells in mu U* r0^2",
        shown=bool(growth.max() > 1.5),
    )


def _disputed(
    evidence: Evidence, varied: str, value: float, diameter: float, packing: float
) -> np.ndarray:
    """alpha of one of the disputed cases over the degree, U/r0."""
    data = evidence.disputed
    [place] = np.flatnonzero(
        (data["varied"] == varied)
        & np.isclose(data["value"], value)
        & np.isclose(data["diameter"], diameter)
        & np.isclose(data["packing"], packing)
    )
    return np.asarray(data["alpha"].values[place])


def _map(evidence: Evidence, resolution: str) -> xr.DataArray:
    return evidence.studies["map"][resolution]["spectral_abscissa"]


def _rate(evidence: Evidence, capillary: float, degree: int) -> str:
    """The solver's growth rate in the paper's unit, D = 8, packing 0.2."""
    of_case = (each for each in evidence.solver["flow_strength"] if each["Ca"] == capillary)
    found = next(each["eigenvalues"][0][0] for each in of_case if each["degree"] == degree)
    return f"{paper_units.rate(found):.3f}"
