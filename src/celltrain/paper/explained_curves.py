"""Explanations of curves over parameters, near neighbours and energies: P19 to P31."""

import numpy as np

from celltrain.paper.evidence import Evidence
from celltrain.paper.explanation import Explanation
from celltrain.paper.finding import at
from celltrain.paper.resolutions import CONVERGED, PAPER


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
