"""Capillaries: viscosity, velocity and film of trains beside measurement and lubrication theory.

And whether these trains are stable. The trains are kept; from nothing ten minutes on two cores
(`capillary_trains`), thirty more the searches (`capillary_searches`), and fifteen of one core the
branches to the fastest flow (`capillary_sides`).
"""

import capillary_dense
import capillary_films
import capillary_searches
import capillary_sides
import capillary_trains as trains
import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator, StrMethodFormatter
from page import Page, plain_figure

from celltrain.diagnostics import in_vitro_fahraeus, in_vitro_viscosity

COLORMAP = colormaps["viridis"]
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
#: What a tube's diameter, um, may be off: the yardstick for differences from the law.
OFF = 0.25
#: Differences from the law beyond this are explained.
LARGE = 0.10
#: Modes, by azimuthal number, as the page calls them.
MODES = {0: "spacing and length", 1: "tilt", 2: "oval section"}


def study() -> None:
    page = Page("capillaries", "Capillaries of 4 to 10 um: viscosity, film, stability")
    measured = page.kept(trains.MEASURED, trains.measured)
    films = page.kept(trains.FILMS, trains.films)
    stable = page.kept(trains.MAP, trains.stability_map)
    low, high = (f"{min(each)} and {max(each)}" for each in (trains.DEGREES, trains.NARROW_DEGREES))
    page.text(
        f"""
Trains of the default cell, r0 = {trains.CELL_RADIUS * 1e6:g} um, plasma of 1.2 mPa s, moduli in SI
as everywhere. All trains have a residual below
{_bound(measured, films, stable):.0e} U. Each was computed at two degrees, M = {low}, or {high} in
tubes below {trains.NARROW:g} r0 ({trains.NARROW * 2.8:.1f} um), there with `grading` 1 in the map
of growth rates at packing {trains.MAP_PACKINGS[1]:g}; what is shown is the higher one, and *error*
is its difference from the lower one.
"""
    )
    _beside_measurement(page, measured)
    capillary_films.section(page, films, stable)
    _stability(page, stable)
    capillary_dense.section(page)
    capillary_sides.section(page)
    capillary_searches.section(page)
    page.figure(
        _figure(measured, stable),
        "Viscosity and the cells' velocity (dots: trains, lines: laws); the film over the speed,"
        " and what a train adds to the viscosity (dots: trains, crosses: lubrication theory);"
        f" growth rates of each m at {trains.SPEED * 1e3:g} mm/s, and the fastest disturbance at"
        f" three speeds. Packing {trains.MAP_PACKINGS[1]:g} but for the first two",
    )
    page.write()


def _bound(*data: xr.Dataset) -> float:
    worst = max(float(each["residual"].max()) for each in data)
    return float(10.0 ** np.ceil(np.log10(worst)))


def _beside_measurement(page: Page, data: xr.Dataset) -> None:
    page.heading("Beside blood in tubes of glass")
    page.text(
        f"""
Mean velocity {trains.SPEED * 1e3:g} mm/s. The packing follows from the discharge haematocrit H_D;
the law of Pries, Neuhaus & Gaehtgens (1992) for the relative apparent viscosity, and that of Pries,
Secomb, Gaehtgens & Gross (1990) for the Fahraeus effect, H_T/H_D = U/U_c, are taken at the H_D that
the train has. *Law's range* is what the law says of tubes {OFF:g} um wider and narrower: as far as
a tube's diameter is known, so far is the law.
"""
    )
    rows = []
    large: list[str] = []
    for diameter in trains.DIAMETERS:
        for share in trains.HAEMATOCRITS:
            at = data.sel(diameter=diameter, haematocrit=share)
            here = float(at["discharge_haematocrit"])
            law, wider, narrower = (
                float(in_vitro_viscosity(max(diameter + off, 3.3), here)) for off in (0, OFF, -OFF)
            )
            viscosity = float(at["viscosity"])
            difference = viscosity / law - 1.0
            if abs(difference) > LARGE:
                large.append(f"{diameter:g} um, {share:g} ({difference:+.0%})")
            rows.append(
                (
                    f"{diameter:g}",
                    f"{here:.3f}",
                    f"{float(at['packing']):.3f}",
                    f"{viscosity:.3f}",
                    f"{abs(viscosity - float(at['coarse_viscosity'])):.0e}",
                    f"{law:.3f}",
                    f"{min(wider, narrower):.2f} to {max(wider, narrower):.2f}",
                    f"{difference:+.1%}",
                    f"{float(at['cell_velocity']):.3f}",
                    f"{1.0 / float(in_vitro_fahraeus(diameter, here)):.3f}",
                    f"{float(at['film']) * 2.8:.2f}",
                    f"{float(at['gap']) * 2.8:.2f}",
                )
            )
    page.table(
        (
            "D, um",
            "H_D",
            "phi",
            "viscosity",
            "error",
            "law",
            "law's range",
            "difference",
            "U_c/U",
            "law",
            "film, um",
            "gap, um",
        ),
        rows,
    )
    velocity = data["cell_velocity"].values
    fahraeus = np.array(
        [
            [
                1.0 / float(in_vitro_fahraeus(d, float(h)))
                for h in data["discharge_haematocrit"].sel(diameter=d)
            ]
            for d in trains.DIAMETERS
        ]
    )
    off = velocity / fahraeus - 1.0
    dense = off[:, np.array(trains.HAEMATOCRITS) >= 0.45]
    page.text(
        f"""
Of {len(rows)} cases {len(rows) - len(large)} are within {LARGE:.0%} of the law. U_c/U differs from
its law by {off.min():+.1%} to {off.max():+.1%}; at H_D >= 0.45 by {dense.min():+.1%} to
{dense.max():+.1%}. The law rises towards low haematocrits, which a train does not: its cells hardly
know of each other there, and a cell's velocity is that of its film. No cell of
these widths on the axis is as fast as the law there.
"""
    )
    if large:
        page.text(_explanation(large))


def _explanation(large: list[str]) -> str:
    return f"""
The others: {", ".join(large)}. In wide tubes at high haematocrits the law is above the trains: the
blood that was measured does not go in single file there, and cells off the axis, near the wall,
cost more than a train on the axis, which is the least resistance that the same cells can have. In
tubes of 4 um the film decides, and with it what is not the same in the measured blood: cells differ
in volume and area, and of two cells the larger one has the thinner film, while viscosity goes as
one over the film; what a tube's diameter being {OFF:g} um off makes of the law is in its range. In
tubes of 6 and 7 um the speed is part of it: films grow with it, and at 2.875 mm/s trains are 5 % to
9 % above the law at 7 um up to a packing of 0.5 ([that page](haematocrit.md)), 6 % to 14 % here;
the law is one of fast flow and does not have the speed.
Nothing in the trains is fitted.
"""


def _stability(page: Page, data: xr.Dataset) -> None:
    page.heading("Are these trains stable?")
    page.text(
        f"""
The fastest disturbance of trains of {trains.CELLS} cells, azimuthal numbers m = 0 to
{min(trains.LOBED) - 1}, in tubes below {trains.NARROW:g} r0 to {max(trains.NUMBERS)} (all waves for
m = 0 and 1, of the others those that are alike in all cells or opposite from cell to cell): its
growth rate alpha in U/r0, *error* its difference from the lower degree, j the waves in the train,
omega the frequency in U/r0 (positive: the pattern moves backwards past the cells), and *travel* how
far the train goes, in r0, while it grows e-fold.
"""
    )
    rows = []
    unstable = 0
    leading: dict[int, int] = {}
    for speed, packing, _, narrowest in sorted(trains.MAP_CASES):
        for diameter in (each for each in trains.MAP_DIAMETERS if each >= narrowest):
            at = data.sel(speed=speed, packing_given=packing, diameter=diameter)
            place = int(np.nanargmax(at["rate"].values))
            m, rate = int(at["m"][place]), float(at["rate"][place])
            error = abs(rate - float(at["coarse_rate"].max()))
            grows = rate > error
            unstable += grows
            if grows:
                leading[m] = leading.get(m, 0) + 1
            travel = float(at["cell_velocity"]) / rate
            rows.append(
                (
                    f"{speed * 1e3:g}",
                    f"{packing:g}",
                    f"{diameter:g} ({diameter * 2.8:.1f} um)",
                    f"{rate:+.4f}",
                    f"{error:.0e}",
                    f"{m}, {MODES.get(m, 'folds along the cell')}",
                    int(at["wave"][place]),
                    f"{float(at['frequency'][place]):+.3f}",
                    f"{travel:.0f}" if grows else "",
                    "unstable" if grows else "stable" if rate < -error else "not resolved",
                )
            )
    page.table(
        ("U, mm/s", "phi", "D, r0", "alpha", "error", "m", "j", "omega", "travel", "train"), rows
    )
    words = ", ".join(f"m = {m} in {count}" for m, count in sorted(leading.items()))
    page.text(
        f"{unstable} of {len(rows)} trains are unstable"
        + (f"; the mode that leads has {words} of them." if words else ".")
        + """ In the wider of these tubes that is a tilt. In the narrowest the membrane, which was a
disc's, is too long around: it is compressed around the axis and folds lengthwise, in several lobes,
at rates that no tilt comes near. An axisymmetric cell is there a state that a real cell does not
keep; its viscosity and film are those of the unfolded shape. The folds are the membrane's finest
pattern and the last that a degree has: without grading they are known to a factor of two at these
degrees (`examples/capillary.py`, 5 um, packing 0.2: 1.72 at M = 24, 1.31 at 32, 1.19 at 40, 1.14 at
56, 1.13 at 64)."""
    )
    page.text(_speeds(data))
    page.text(_missing())


def _speeds(data: xr.Dataset) -> str:
    """How the growth rates go with the speed, in words."""
    packing = trains.MAP_PACKINGS[1]
    words = []
    for speed, share, _, narrowest in sorted(trains.MAP_CASES):
        if share != packing:
            continue
        here = data.sel(speed=speed, packing_given=packing)
        second = speed / trains.CELL_RADIUS
        parts = []
        for diameter in (narrowest, max(trains.MAP_DIAMETERS)):
            at = here.sel(diameter=diameter)
            rate, coarse = float(at["rate"].max()), float(at["coarse_rate"].max())
            parts.append(
                f"{rate:.3g} +- {abs(rate - coarse):.1g} U/r0 ({rate * second:.3g}/s) at"
                f" D = {diameter:g}"
            )
        words.append(f"{speed * 1e3:g} mm/s: {', '.join(parts)}")
    highest = max(trains.NUMBERS)
    leading = int(data["rate"].fillna(-np.inf).argmax("m").max())
    edge = (
        f"Where m = {highest} leads, the highest that was looked at, higher ones may be faster."
        if leading == highest
        else f"No train is led by an m above {leading}."
    )
    return f"""
With the speed, at packing {packing:g}: {"; ".join(words)}. In units of the flow a membrane grows
faster the weaker the flow; per second the folds at D = 1.6 and 2 at the two lower speeds differ by
less than a factor of two, those at D = 2.5 grow at the lowest alone. {edge}
"""


def _missing() -> str:
    """What the map lacks, and what was tried there."""
    fast = max(trains.MAP_SPEEDS)
    narrowest = next(each[3] for each in trains.MAP_CASES if each[0] == fast)
    packing = min(trains.MAP_PACKINGS)
    return f"""
Not in the map: the fastest flow in tubes below D = {narrowest:g}, and packing {packing:g} at other
speeds than {trains.SPEED * 1e3:g} mm/s. In the fastest flow two sides of the cells meet there (see
below).
"""


def _figure(measured: xr.Dataset, stable: xr.Dataset) -> Figure:
    figure = plain_figure(8.6, 9.8)
    (viscosity, velocity), (film, cost), (growth, fastest) = figure.subplots(3, 2)
    wide = np.linspace(min(trains.DIAMETERS), max(trains.DIAMETERS), 100)
    for share, color in zip(trains.HAEMATOCRITS, COLORS, strict=False):
        at = measured.sel(haematocrit=share)
        viscosity.plot(wide, [in_vitro_viscosity(d, share) for d in wide], color=color, lw=1)
        viscosity.plot(at["diameter"], at["viscosity"], "o", color=color, ms=4, label=f"{share:g}")
        velocity.plot(wide, [1 / in_vitro_fahraeus(d, share) for d in wide], color=color, lw=1)
        velocity.plot(at["diameter"], at["cell_velocity"], "o", color=color, ms=4)
    viscosity.set(xlabel=r"D ($\mu$m)", ylabel="viscosity over plasma's")
    viscosity.legend(title="H_D", fontsize=7, title_fontsize=7, frameon=False)
    velocity.set(xlabel=r"D ($\mu$m)", ylabel=r"$U_c/U$")
    packing = trains.MAP_PACKINGS[1]
    for diameter, color in zip(trains.MAP_DIAMETERS, COLORS, strict=False):
        at = stable.sel(diameter=diameter, packing_given=packing)
        speeds = at["speed"] * 1e3
        film.loglog(speeds, at["film"], "o-", color=color, ms=4, lw=1, label=f"D = {diameter:g}")
        cost.loglog(speeds, at["viscosity"] - 1.0, "o-", color=color, ms=4, lw=1)
        cost.loglog(speeds, at["lubricated_viscosity"] - 1.0, "x", color=color, ms=5)
    slope = np.array([0.1, 0.3])
    film.loglog(slope, 0.08 * (slope / 0.1) ** (2 / 3), "k--", lw=0.8, label=r"$U^{2/3}$")
    film.set(xlabel="U (mm/s)", ylabel=r"film ($r_0$)")
    cost.set(xlabel="U (mm/s)", ylabel=r"$\mu_{\rm eff} - 1$")
    for axis, ticks in (
        *((panel.xaxis, (0.1, 1, 10)) for panel in (film, cost)),
        (film.yaxis, (0.05, 0.1, 0.2, 0.5, 1)),
        (cost.yaxis, (0.05, 0.1, 0.2, 0.5, 1, 2)),
    ):
        axis.set_major_locator(FixedLocator(ticks))
        axis.set_major_formatter(StrMethodFormatter("{x:g}"))
        axis.set_minor_locator(NullLocator())
    film.legend(fontsize=7, frameon=False)
    at = stable.sel(speed=trains.SPEED, packing_given=packing)
    least = -1.5
    for m in trains.NUMBERS:
        if at["rate"].sel(m=m).max() < least:
            continue
        color = COLORMAP(m / max(trains.NUMBERS))
        growth.plot(at["diameter"], at["rate"].sel(m=m), color=color, lw=1, label=f"m = {m}")
    growth.set(xlabel=r"D ($r_0$)", ylabel=r"growth rate ($U/r_0$)", ylim=(least, 2.0))
    growth.legend(fontsize=6.5, frameon=False, ncols=3)
    for speed, color in zip(trains.MAP_SPEEDS, COLORS, strict=False):
        at = stable.sel(speed=speed, packing_given=packing)
        error = np.abs(at["rate"].max("m") - at["coarse_rate"].max("m"))
        fastest.errorbar(
            at["diameter"],
            at["rate"].max("m"),
            error,
            fmt="o-",
            color=color,
            ms=4,
            lw=1,
            capsize=2,
            label=f"{speed * 1e3:g} mm/s",
        )
    fastest.set_yscale("symlog", linthresh=0.1, linscale=0.5)
    fastest.set(xlabel=r"D ($r_0$)", ylabel=r"fastest growth rate ($U/r_0$)")
    fastest.legend(fontsize=7, frameon=False)
    for panel in (growth, fastest):
        panel.axhline(0.0, color="0.6", lw=0.6, zorder=0)
    return figure
