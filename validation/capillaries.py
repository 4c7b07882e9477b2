"""Capillaries: viscosity, velocity and film of trains beside measurement and lubrication theory.

And whether these trains are stable. The trains are kept; from nothing ten minutes on two cores
(`capillary_trains`).
"""

from itertools import pairwise

import capillary_trains as trains
import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator, StrMethodFormatter
from page import Page, plain_figure

from celltrain.diagnostics import in_vitro_fahraeus, in_vitro_viscosity
from celltrain.diagnostics.lubrication import rigid_bullet

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
tubes below {trains.NARROW:g} r0 ({trains.NARROW * 2.8:.1f} um); what is shown is the higher one,
and *error* is its difference from the lower one.
"""
    )
    _beside_measurement(page, measured)
    _film(page, films)
    _stability(page, stable)
    page.figure(
        _figure(measured, films, stable),
        "Viscosity and the cells' velocity (dots: trains, lines: laws); the film over the speed;"
        f" growth rates at {trains.MAP_SPEEDS[0] * 1e3:g} mm/s (packing"
        f" {trains.MAP_PACKINGS[0]:g}: full lines, {trains.MAP_PACKINGS[1]:g}: dashed)",
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


def _film(page: Page, data: xr.Dataset) -> None:
    page.heading("The film, and lubrication theory of a bullet")
    page.text(
        """
A long rigid cylinder of radius a = lambda R, free of force, in a tube of radius R: in the film the
flow is u = G (R^2 - r^2)/4 + c log(R/r), mu = 1, and the balance of the cell, pressure pi a^2 G
against the shear force, asks for c = 0. So the film has the plain parabola at a pressure gradient
G, and the flux pi R^2 U = pi a^2 U_c + 2 pi int_a^R u r dr gives
"""
    )
    page.parts.append(
        "    U_c/U = 2/(1 + lambda^2),    G = (8 U/R^2)/(1 - lambda^4),\n\n"
        "    thin films, h = R - a:   U_c/U = 1 + h/R,   dp - dp_plain = 2 mu U l/(R h),\n\n"
        "    mu_eff - 1 = (l/L) lambda^4/(1 - lambda^4)  ->  (l/L) R/(4 h),"
    )
    page.text(
        """
l the length of the cylinder and L that of tube for each cell. A cell whose radius a(z) varies
slowly has the flow of an annulus at each z; that the flux is the same everywhere, and the force
none, gives its U_c and pressure drop (`celltrain.diagnostics.lubricated`, which has the equations).
What the film is, elasticity decides. At the nose it opens from the wall as a membrane of tension T
bends away from it: the pressure p = -T h'' and the flux in the frame of the cell,
h^3 p'/12 - U_c h/2 = -U_c h_0/2, give
"""
    )
    page.parts.append("    T h''' = 6 mu U_c (h - h_0)/h^3,")
    page.text(
        """
which is the equation of a long bubble (Bretherton 1961) with 6 in place of 3, as the membrane does
not slip: h_0/R = 0.643 (6 mu U_c/T)^(2/3). So where the tension is that of the cell pressed into
the tube, whatever the speed, the film grows as U^(2/3); where the flow itself makes the tension, T
as mu U, it no longer grows with the speed. The power that is seen, from one speed to the next, is
in the table.
"""
    )
    rows: list[tuple[object, ...]] = []
    for diameter in trains.FILM_DIAMETERS:
        at = data.sel(diameter=diameter)
        powers = ["", *(f"{each:.2f}" for each in powers_of(at))]
        for place, speed in enumerate(trains.FILM_SPEEDS):
            here = at.isel(speed=place)
            film, radius = float(here["film"]), diameter / 2.0
            velocity, viscosity = float(here["cell_velocity"]), float(here["viscosity"])
            rough = rigid_bullet(1.0 - film / radius)
            part = float(here["length"] * here["packing"])
            rows.append(
                (
                    f"{diameter:g}",
                    f"{speed * 1e3:g}",
                    f"{film:.4f}",
                    f"{abs(film - float(here['coarse_film'])) / film:.1%}",
                    powers[place],
                    f"{velocity:.4f}",
                    f"{float(here['lubricated_velocity']):.4f}",
                    f"{rough[0]:.4f}",
                    f"{viscosity - 1.0:.3f}",
                    f"{abs(viscosity - float(here['coarse_viscosity'])) / (viscosity - 1.0):.1%}",
                    f"{float(here['lubricated_viscosity']) - 1.0:.3f}",
                    f"{part * (rough[1] - 1.0):.3f}",
                )
            )
    page.table(
        (
            "D, r0",
            "U, mm/s",
            "film, r0",
            "error",
            "power of U",
            "U_c/U",
            "lubrication",
            "bullet",
            "mu_eff - 1",
            "error",
            "lubrication",
            "bullet",
        ),
        rows,
    )
    page.text(
        f"""
Packing {trains.FILM_PACKING:g}. The film is the smallest distance from the wall; *lubrication*
takes the computed shape of the cell, *bullet* a cylinder with that film and the cell's length,
which makes it an upper bound of the pressure drop. (mu_eff - 1) times 8 L/R^2 is the pressure drop
of one
cell in mu U/r0.
"""
    )


def powers_of(data: xr.Dataset) -> list[float]:
    """d log(film)/d log(U) from one speed to the next."""
    points = list(zip(np.log(data["speed"].values), np.log(data["film"].values), strict=True))
    return [float((b[1] - a[1]) / (b[0] - a[0])) for a, b in pairwise(points)]


def _stability(page: Page, data: xr.Dataset) -> None:
    page.heading("Are these trains stable?")
    page.text(
        f"""
The fastest disturbance of trains of {trains.CELLS} cells, azimuthal numbers m = 0 to
{max(trains.NUMBERS)} (all waves for m = 0 and 1, of the others those that are alike in all cells or
opposite from cell to cell): its growth rate alpha in U/r0, *error* its difference from the lower
degree, j the waves in the train, omega the frequency in U/r0 (positive: the pattern moves backwards
past the cells), and *travel* how far the train goes, in r0, while it grows e-fold.
"""
    )
    rows = []
    unstable = 0
    leading: dict[int, int] = {}
    for speed in trains.MAP_SPEEDS:
        for packing in trains.MAP_PACKINGS:
            for diameter in trains.MAP_DIAMETERS:
                at = data.sel(speed=speed, packing_given=packing, diameter=diameter)
                place = int(np.argmax(at["rate"].values))
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
pattern and the last that a degree has: the rates are right to a factor of two there, and what is
sure of them is the sign (`examples/capillary.py`, 5 um, packing 0.2: 1.72 at M = 24, 1.31 at
32, 1.19 at 40, 1.14 at 56, 1.13 at 64)."""
    )


def _figure(measured: xr.Dataset, films: xr.Dataset, stable: xr.Dataset) -> Figure:
    figure = plain_figure(8.6, 6.8)
    (viscosity, velocity), (film, growth) = figure.subplots(2, 2)
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
    for diameter, color in zip(trains.FILM_DIAMETERS, COLORS, strict=False):
        at = films.sel(diameter=diameter)
        film.loglog(
            at["speed"] * 1e3, at["film"], "o-", color=color, ms=4, lw=1, label=f"D = {diameter:g}"
        )
    slope = np.array([0.2, 0.5])
    film.loglog(slope, 0.09 * (slope / 0.2) ** (2 / 3), "k--", lw=0.8, label=r"$U^{2/3}$")
    film.set(xlabel="U (mm/s)", ylabel=r"film ($r_0$)")
    for axis, ticks in ((film.xaxis, (0.2, 0.5, 1, 2)), (film.yaxis, (0.1, 0.12, 0.15, 0.18))):
        axis.set_major_locator(FixedLocator(ticks))
        axis.set_major_formatter(StrMethodFormatter("{x:g}"))
        axis.set_minor_locator(NullLocator())
    film.legend(fontsize=7, frameon=False)
    speed = trains.MAP_SPEEDS[0]
    for packing, style in zip(trains.MAP_PACKINGS, ("-", "--"), strict=True):
        at = stable.sel(speed=speed, packing_given=packing)
        for m in trains.NUMBERS:
            label = f"m = {m}" if packing == trains.MAP_PACKINGS[0] else None
            color = COLORMAP(m / max(trains.NUMBERS))
            growth.plot(at["diameter"], at["rate"].sel(m=m), style, color=color, lw=1, label=label)
    growth.axhline(0.0, color="0.6", lw=0.6, zorder=0)
    growth.set(xlabel=r"D ($r_0$)", ylabel=r"growth rate ($U/r_0$)", ylim=(-1.5, 2.0))
    growth.legend(fontsize=6.5, frameon=False, ncols=2)
    return figure
