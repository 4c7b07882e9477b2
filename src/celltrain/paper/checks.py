"""What the paper says of its own accuracy (P2, P3): other moduli, more cells, its box."""

import numpy as np
import scipy.sparse
import xarray as xr

from celltrain.paper.finding import Finding, finding
from celltrain.paper.trains import CELLS, CORNERS, analysed, dataset

#: The side of the paper's box less the diameter, r0, and its ratios of velocities.
AROUND, RATIO = 0.5, (1.244, 1.256)
#: How far the ratio may be from the paper's.
RATIO_LEEWAY = 0.003
DIAMETERS = (6.0, 8.0, 10.0, 12.0)
#: Relative changes of alpha that the paper allows: a larger Ed, more cells.
STIFFER, LONGER = 0.02, 0.01
# Points of the finer of two grids across the box.
POINTS = 400


def compute(degree: int | None) -> xr.Dataset:
    """alpha of four trains, with twice Ed, and with twice as many cells; the box's velocities."""
    found = np.full((len(CORNERS), 3), np.nan)
    viscosities = []
    for row, (diameter, packing) in enumerate(CORNERS):
        usual = analysed(degree, diameter=diameter, packing=packing)
        twice = 2.0 * usual.base.train.cell.dilatation_modulus
        stiff = analysed(degree, diameter=diameter, packing=packing, dilatation_modulus=twice)
        longer = analysed(degree, cells=2 * CELLS, diameter=diameter, packing=packing)
        found[row] = [each.spectral_abscissa for each in (usual, stiff, longer)]
        viscosities.append(usual.base.effective_viscosity)
    ratios = [
        [velocity_ratio(diameter, viscosity) for diameter in DIAMETERS]
        for viscosity in (1.0, max(viscosities))
    ]
    return dataset(
        {
            "alpha": (("train", "change"), found, "U/r0", "largest growth rate"),
            "ratio": (
                ("viscosity", "tube"),
                np.array(ratios),
                "1",
                "mean velocity in the tube over that in the paper's box",
            ),
        },
        {
            "change": ["none", "twice Ed", "twice as many cells"],
            "diameter": ("train", [each[0] for each in CORNERS], {"units": "r0"}),
            "packing": ("train", [each[1] for each in CORNERS]),
            "tube": ("tube", list(DIAMETERS), {"units": "r0"}),
            "viscosity": ("viscosity", [1.0, max(viscosities)], {"units": "mu"}),
        },
        "alpha with other moduli and lengths; velocities in the paper's box",
    )


def velocity_ratio(diameter: float, viscosity: float) -> float:
    """Mean velocity in the tube over that in the (D + 0.5)^2 box around it, U/U^.

    The same pressure drop moves fluid inside, of an effective viscosity, and plasma outside, which
    rests on the tube's wall: Laplace's equation with a constant source in the periodic square less
    the disc, by differences on two grids, extrapolated.
    """
    coarse, fine = (_outside(diameter, points) for points in (POINTS // 2, POINTS))
    outside = 2.0 * fine - coarse
    radius, side = 0.5 * diameter, diameter + AROUND
    inside = np.pi * radius**4 / 8.0 / viscosity
    return float(inside / (np.pi * radius**2) / ((inside + outside) / side**2))


def _outside(diameter: float, points: int) -> float:
    """Flow rate outside the tube for a unit pressure gradient, r0^4."""
    step = (diameter + AROUND) / points
    place = (np.arange(points) + 0.5) * step - 0.5 * (diameter + AROUND)
    outside = np.hypot(*np.meshgrid(place, place)) > 0.5 * diameter
    count = int(outside.sum())
    number = np.full(outside.shape, -1)
    number[outside] = np.arange(count)
    matrix = scipy.sparse.identity(count, format="csc") * 4.0
    for axis in (0, 1):
        for shift in (1, -1):
            beside = np.roll(number, shift, axis=axis)[outside]
            known = np.flatnonzero(beside >= 0)
            ones = np.ones(known.size)
            shape = (count, count)
            matrix = matrix - scipy.sparse.csc_matrix((ones, (known, beside[known])), shape=shape)
    velocity = scipy.sparse.linalg.spsolve(matrix.tocsc(), np.full(count, step**2))
    return float(velocity.sum() * step**2)


def findings(data: xr.Dataset) -> list[Finding]:
    """The statements about accuracy that can be told from these."""
    usual, stiff, longer = data["alpha"].values.T
    ratios = data["ratio"].values
    lowest, highest = float(ratios.min()), float(ratios.max())
    changes = {
        "doubling Ed changes alpha by less than 2 %": (stiff / usual - 1.0, STIFFER),
        "doubling N changes alpha by less than 1 %": (longer / usual - 1.0, LONGER),
    }
    return [
        finding(
            "P2",
            f"the mean velocity in the tube is {RATIO[0]:g} to {RATIO[1]:g} of that in the box",
            f"{lowest:.3f} to {highest:.3f} (D = {DIAMETERS[-1]:g} to {DIAMETERS[0]:g}; a round,"
            " impermeable wall)",
            RATIO[0] - RATIO_LEEWAY < lowest and highest < RATIO[1] + RATIO_LEEWAY,
            ratios,
        ),
        *(
            finding(
                "P3",
                words,
                ", ".join(f"{each:+.1%}" for each in values) + " in four trains",
                bool((np.abs(values) < allowed).all()),
                values,
            )
            for words, (values, allowed) in changes.items()
        ),
    ]
