"""Viscosity inside the cells: Figs. 13 and 14, and the paper's statements about them (Sec. V C)."""

from functools import partial

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from celltrain.paper.curves import draw_curves, side_by_side
from celltrain.paper.finding import Finding, at, finding, in_paper_units, number
from celltrain.paper.resolutions import Resolutions, best

#: What "about a factor of two", "insensitive" and "about four times" may mean.
HALVED, INSENSITIVE, FOURFOLD = (0.4, 0.6), (0.7, 1.4), (2.0, 8.0)
#: Packings up to this one are sparse, from this one on dense.
SPARSE_BELOW, DENSE_FROM = 0.3, 0.6
#: What "about 10 %", "approximately a plateau", "many times" and "lam ~ 1" may mean.
TENTH, PLATEAU, MANY, ABOUT_ONE = (0.0, 0.25), 0.1, 3.0, (0.4, 2.5)
SPARSE, DENSE = 0.2, 0.7
#: The fluid cell, the reference, where the paper's plateau begins, and its end.
LEAST, ONE, STIFF, MOST = 0.1, 1.0, 20.0, 100.0


def draw_over_packing(data: Resolutions) -> Figure:
    """Fig. 13: eta and alpha over the packing, in the paper's unit."""
    figure, (left, right) = side_by_side(2)

    def rate(each: xr.Dataset, name: str) -> xr.DataArray:
        return in_paper_units(each[name])

    def growing(each: xr.Dataset) -> xr.DataArray:
        # As in the paper, what grows more slowly than 1e-3 is not drawn.
        alpha = rate(each, "spectral_abscissa")
        return alpha.where(alpha > 1e-3)

    draw_curves(left, data, partial(rate, name="numerical_abscissa"), "packing", legend=False)
    left.set(xlabel=r"$\phi$", ylabel=r"$\eta\, r_0/U^*$", ylim=(0.0, None))
    bars = partial(rate, name="error_estimate")
    draw_curves(right, data, growing, "packing", bars, legend=False)
    right.set(xlabel=r"$\phi$", ylabel=r"$\alpha\, r_0/U^*$", yscale="log", ylim=(1e-3, None))
    handles, labels = right.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, fontsize=7, frameon=False)
    return figure


def draw_over_ratio(data: Resolutions) -> Figure:
    """Fig. 14: alpha, tumbling and tank-treading of the leading mode over the viscosity ratio.

    Rates of turning for each unit of the disturbance's amplitude, in the paper's unit of time;
    those of the converged modes, if there are any.
    """
    figure, panels = side_by_side(2)
    turning = best(data)
    for axes, packing in zip(panels, (SPARSE, DENSE), strict=True):

        def rate(each: xr.Dataset, name: str, packing: float = packing) -> xr.DataArray:
            return in_paper_units(at(each[name], packing=packing))

        alpha, bars = (partial(rate, name=name) for name in ("spectral_abscissa", "error_estimate"))
        draw_curves(axes, data, alpha, "viscosity_ratio", bars, legend=False)
        axes.set(xscale="log", xlabel=r"$\lambda$", ylabel=r"$\alpha\, r_0/U^*$")
        axes.set_title(f"{axes.get_title()}  $\\phi$ = {packing:g}", fontsize=10)
        other = axes.twinx()
        for name, style, label in (
            ("tumbling", "--", r"$|\omega|$"),
            ("tank_treading", ":", r"$|\Omega - \omega|$"),
        ):
            found = rate(turning, name)
            for place, diameter in enumerate(found.diameter.values):
                curve = at(found, diameter=diameter)
                words = rf"{label}, $D/r_0$ = {diameter:g}"
                color = f"C{place}"
                other.plot(curve.viscosity_ratio, curve, style, color=color, lw=1.0, label=words)
        other.set(ylabel=r"$|\omega|$, $|\Omega - \omega|$  ($U^*/r_0^2$)", ylim=(0.0, None))
    # Both panels have the same curves: one legend for them, below.
    curves = [each.get_legend_handles_labels() for each in (axes, other)]
    drawn = {
        words: line for lines, names in curves for line, words in zip(lines, names, strict=True)
    }
    figure.legend(
        list(drawn.values()),
        list(drawn),
        loc="outside lower center",
        ncols=4,
        fontsize=7,
        frameon=False,
    )
    return figure


def packing_findings(data: xr.Dataset) -> list[Finding]:
    """The statements about lam = 1 and 5 over the packing (Fig. 13)."""
    alpha = in_paper_units(data["spectral_abscissa"])
    eta = data["numerical_abscissa"]
    one, five = at(alpha, viscosity_ratio=ONE), at(alpha, viscosity_ratio=5.0)
    halves = at(eta, viscosity_ratio=5.0) / at(eta, viscosity_ratio=ONE)
    ratio = (five / one).where(one > 0.0)
    sparse = ratio.sel(packing=ratio.packing <= SPARSE_BELOW + 1e-9)
    dense = ratio.sel(packing=ratio.packing >= DENSE_FROM - 1e-9)
    above = (five > one).sel(packing=one.packing > SPARSE_BELOW + 1e-9)
    unstable = dense.values[np.isfinite(dense.values)]
    return [
        finding(
            "P19",
            "eta at viscosity ratio 5 is about half of that at 1, at every packing",
            f"factors {halves.min().item():.2f} to {halves.max().item():.2f}",
            _all_inside(halves, HALVED),
            halves,
        ),
        finding(
            "P20",
            f"alpha is insensitive to a viscosity ratio of 5 up to packing {SPARSE_BELOW:g}",
            _places(sparse),
            _all_inside(sparse.fillna(0.0), INSENSITIVE),
            one.sel(packing=sparse.packing),
        ),
        finding(
            "P20",
            "alpha is larger at viscosity ratio 5 in all denser trains",
            f"in {int(above.sum())} of {above.size}",
            above.all(),
            five,
        ),
        finding(
            "P20",
            f"alpha is about four times as large at viscosity ratio 5 from packing {DENSE_FROM:g}"
            " on",
            _places(dense) + f"; {dense.size - unstable.size} of {dense.size} stable at ratio 1",
            unstable.size > 0 and _all_inside(unstable, FOURFOLD),
            one.sel(packing=dense.packing),
        ),
    ]


def ratio_findings(data: xr.Dataset) -> list[Finding]:
    """The statements about the viscosity ratio (Fig. 14), in each tube."""
    return [each for diameter in data.diameter.values for each in _of_tube(data, diameter)]


def _of_tube(data: xr.Dataset, diameter: float) -> list[Finding]:
    where = f"D = {diameter:g}, packing"
    # As far as the paper goes.
    data = data.sel(viscosity_ratio=data.viscosity_ratio <= MOST + 1e-9)

    def of(name: str, packing: float, ratio: float) -> float:
        return float(at(data[name], diameter=diameter, packing=packing, viscosity_ratio=ratio))

    def alpha(packing: float, ratio: float) -> float:
        return of("spectral_abscissa", packing, ratio)

    def change(packing: float, first: float, last: float) -> float:
        return alpha(packing, last) / alpha(packing, first) - 1.0

    thin = {ratio: alpha(SPARSE, ratio) for ratio in (LEAST, ONE, STIFF, MOST)}
    thick = at(data["spectral_abscissa"], diameter=diameter, packing=DENSE)
    spread = {
        packing: at(data["spectral_abscissa"], diameter=diameter, packing=packing)
        for packing in (SPARSE, DENSE)
    }
    ranges = {packing: float(each.max() - each.min()) for packing, each in spread.items()}
    known = np.isfinite(thick).all()
    softest = float(thick.viscosity_ratio[np.argmin(thick.values)]) if known else np.nan
    beyond = change(DENSE, STIFF, MOST)
    turning = [
        (rate, packing, first, last)
        for rate, first, last in (("tumbling", ONE, STIFF), ("tank_treading", ONE, LEAST))
        for packing in (SPARSE, DENSE)
    ]
    return [
        finding(
            "P21",
            f"{where} {SPARSE:g}: alpha grows by about 10 % from ratio 1 to 20",
            f"{change(SPARSE, ONE, STIFF):+.1%}, from {_rate(data, diameter, SPARSE, ONE)}",
            TENTH[0] < change(SPARSE, ONE, STIFF) < TENTH[1],
            list(thin.values()),
        ),
        finding(
            "P21",
            f"{where} {SPARSE:g}: alpha has a plateau beyond ratio 20",
            f"{change(SPARSE, STIFF, MOST):+.1%} from 20 to 100",
            abs(change(SPARSE, STIFF, MOST)) < PLATEAU,
            list(thin.values()),
        ),
        finding(
            "P21",
            f"{where} {SPARSE:g}: alpha is slightly larger at ratios below 1",
            f"{change(SPARSE, ONE, LEAST):+.1%} at 0.1",
            0.0 < change(SPARSE, ONE, LEAST) < 0.5,
            list(thin.values()),
        ),
        finding(
            "P22",
            f"{where} {DENSE:g}: alpha is many times more sensitive to the ratio",
            f"alpha varies by {ranges[DENSE]:.2g} U/r0, against {ranges[SPARSE]:.2g} at packing"
            f" {SPARSE:g}",
            ranges[DENSE] > MANY * ranges[SPARSE],
            xr.concat(list(spread.values()), "packing"),
        ),
        finding(
            "P22",
            f"{where} {DENSE:g}: a ratio of about 1 is the most stable",
            f"smallest at {softest:g}: {_rate(data, diameter, DENSE, softest)}",
            ABOUT_ONE[0] <= softest <= ABOUT_ONE[1],
            thick,
        ),
        finding(
            "P22",
            f"{where} {DENSE:g}: alpha has a plateau beyond ratio 20",
            f"{beyond:+.1%} from 20 to 100",
            abs(beyond) < PLATEAU,
            thick,
        ),
        *(
            finding(
                "P23",
                f"{where} {packing:g}: {rate.replace('_', '-')} rises from ratio {first:g} to"
                f" {last:g}",
                f"by a factor {of(rate, packing, last) / of(rate, packing, first):.2f}",
                of(rate, packing, last) > of(rate, packing, first),
                [of(rate, packing, each) for each in (first, last)],
            )
            for rate, packing, first, last in turning
        ),
    ]


def _rate(data: xr.Dataset, diameter: float, packing: float, ratio: float) -> str:
    """A growth rate in the paper's unit, with its error."""
    place = {"diameter": diameter, "packing": packing, "viscosity_ratio": ratio}
    return number(
        *(
            at(in_paper_units(data[name]), **place)
            for name in ("spectral_abscissa", "error_estimate")
        )
    )


def _all_inside(values: xr.DataArray | np.ndarray, limits: tuple[float, float]) -> bool:
    return bool(((values > limits[0]) & (values < limits[1])).all())


def _places(ratios: xr.DataArray) -> str:
    """Ratios with their places; those of trains that are stable at ratio 1 are left out."""
    return ", ".join(
        f"D {diameter:g}, {packing:g}: {value:.2f}"
        for diameter in ratios.diameter.values
        for packing in ratios.packing.values
        if np.isfinite(value := float(ratios.sel(diameter=diameter, packing=packing)))
    )
