"""The film of trains in narrow tubes, and their pressure drop, beside lubrication theory."""

from itertools import pairwise

import capillary_trains as trains
import numpy as np
import xarray as xr
from page import Page

from celltrain.diagnostics.lubrication import rigid_bullet


def section(page: Page, data: xr.Dataset, stable: xr.Dataset) -> None:
    """The section of the page, from `films` and the map of `capillary_trains`."""
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
        powers, costs = (
            ["", *(f"{each:+.2f}" for each in powers_of(at["speed"], values))]
            for values in (at["film"], at["viscosity"] - 1.0)
        )
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
                    costs[place],
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
            "power",
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
of one cell in mu U/r0.
"""
    )
    _over_speeds(page, stable)


def _over_speeds(page: Page, data: xr.Dataset) -> None:
    """The film and the pressure drop over two decades of the speed."""
    packing = trains.MAP_PACKINGS[1]
    page.text(
        f"""
From {trains.MAP_SPEEDS[0] * 1e3:g} to {trains.MAP_SPEEDS[-1] * 1e3:g} mm/s, packing {packing:g};
*power* is that of the speed from one row to the next, and its *lubrication* that of lubrication
theory on the computed shapes:
"""
    )
    rows: list[tuple[object, ...]] = []
    films, drops = list[float](), list[float]()
    for diameter in trains.MAP_DIAMETERS:
        at = data.sel(diameter=diameter, packing_given=packing)
        added, theory = at["viscosity"] - 1.0, at["lubricated_viscosity"] - 1.0
        speeds = at["speed"]
        powers = [powers_of(speeds, each) for each in (at["film"], added, theory)]
        films += [each for each in powers[0] if np.isfinite(each)]
        drops += [each for each in powers[1] if np.isfinite(each)]
        for place, speed in enumerate(trains.MAP_SPEEDS):
            here = at.isel(speed=place)
            if np.isnan(here["film"]):
                continue
            film, coarse = float(here["film"]), float(here["coarse_film"])
            cost = float(added[place])
            off = abs(float(here["viscosity"] - here["coarse_viscosity"]))
            shown = [f"{each[place - 1]:+.2f}" if place else "" for each in powers]
            rows.append(
                (
                    f"{diameter:g}",
                    f"{speed * 1e3:g}",
                    f"{film:.4f}",
                    f"{abs(film - coarse) / film:.1%}",
                    shown[0],
                    f"{float(here['cell_velocity']):.4f}",
                    f"{cost:.3f}",
                    f"{off / cost:.1%}",
                    shown[1],
                    f"{float(theory[place]):.3f}",
                    shown[2],
                )
            )
    page.table(
        (
            "D, r0",
            "U, mm/s",
            "film, r0",
            "error",
            "power",
            "U_c/U",
            "mu_eff - 1",
            "error",
            "power",
            "lubrication",
            "power",
        ),
        rows,
    )
    page.text(
        f"""
The film goes by powers of {min(films):.2f} to {max(films):.2f} of the speed, mu_eff - 1 by
{min(drops):+.2f} to {max(drops):+.2f}, and the pressure drop by one more. A power of 2/3, that of a
film under a given tension, is reached nowhere in this range.
"""
    )


def powers_of(speeds: xr.DataArray, values: xr.DataArray) -> list[float]:
    """d log(value)/d log(U) from one speed to the next."""
    points = list(zip(np.log(speeds.values), np.log(values.values), strict=True))
    return [float((b[1] - a[1]) / (b[0] - a[0])) for a, b in pairwise(points)]
