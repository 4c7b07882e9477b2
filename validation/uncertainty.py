"""How much the growth rate, the velocity and the apparent viscosity vary where cells differ."""

import itertools
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import scipy
import xarray as xr
from page import Page, plain_figure

from celltrain import stability
from celltrain.parameters.fields import symbol
from celltrain.parameters.routing import TAKEN
from celltrain.stability import parameter_sensitivities
from celltrain.study import (
    SampledStudy,
    collect_sample,
    local_workers,
    make_sampled_study,
    run_sample,
)
from celltrain.study.sampling.statistics import WithErrors, estimated, sobol_indices

HERE = Path(__file__).resolve().parent
DATA = HERE.parent / "docs" / "validation" / "data"
POINTS = 256
STUDY: dict[str, Any] = {
    "title": "cells that differ",
    "case": {"diameter": 6, "packing": 0.2, "cells": 8},
    "distributions": {
        "reduced_volume": {"normal": {"relative_deviation": 0.12}},
        "shear_modulus": {"lognormal": {"relative_deviation": 0.3}},
        "dilatation_modulus": {"lognormal": {"relative_deviation": 0.3}},
        "bending_modulus": {"lognormal": {"relative_deviation": 0.3}},
    },
    "sample": {"points": POINTS},
}
#: The same with cells of one shape, whose size differs: a third of the volume's deviation.
SIZES = {
    "title": "cells of one shape",
    "units": "SI",
    "case": {"diameter": 16.8e-6, "packing": 0.2, "cells": 8},
    "distributions": {
        "radius": {"lognormal": {"relative_deviation": 0.04}},
        **{name: each for name, each in STUDY["distributions"].items() if "modulus" in name},
    },
    "sample": {"points": POINTS // 4},
}
OUTPUTS = {
    "spectral_abscissa": "alpha, U/r0",
    "cell_velocity": "U_c, U",
    "effective_viscosity": "apparent viscosity, mu",
}
#: What is kept of each train.
KEPT = (*OUTPUTS, "leading_azimuthal_number", "error_estimate", "processor_seconds")
#: Largest degree of the polynomials that are fitted.
DEGREE = 4
TRAINS = 10_000


def sample(page: Page, content: Mapping[str, Any], folder: Path) -> xr.Dataset:
    """All trains, kept in the folder: killed, it goes on when run again."""
    study = make_sampled_study(content)
    folder.mkdir(parents=True, exist_ok=True)
    with local_workers() as workers:
        found = run_sample(
            study,
            folder.absolute(),
            workers.executor,
            workers.slots,
            progress=lambda told: page.log(f"{told.finished} of {told.total}"),
        )
    data = collect_sample(study, found).data
    return data[[*KEPT, *study.names, "distribution"]].drop_vars("output", errors="ignore")


def outputs(data: xr.Dataset, points: int | None = None) -> np.ndarray:
    """The outputs of the first points, by output, matrix and point."""
    return np.stack([data[name].values[:, :points] for name in OUTPUTS])


def fitted(study: SampledStudy, data: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """First-order indices and the part of the variance that polynomials explain, by output.

    Orthonormal Hermite polynomials of the parameters' scores, up to a total degree, are fitted to
    all trains; a sum of squares of their coefficients is then a part of the variance.
    """
    count = len(study.names)
    scores = np.stack(
        [each.scores(data[each.name].values.ravel()) for each in study.distributions], axis=1
    )
    powers = [
        each for each in itertools.product(range(DEGREE + 1), repeat=count) if sum(each) <= DEGREE
    ]
    single = [
        scipy.special.eval_hermitenorm(n, scores) / np.sqrt(scipy.special.factorial(n))
        for n in range(DEGREE + 1)
    ]
    basis = np.stack(
        [np.prod([single[n][:, i] for i, n in enumerate(each)], axis=0) for each in powers], axis=1
    )
    found, explained = [], []
    for name in OUTPUTS:
        values = data[name].values.ravel()
        known = np.isfinite(values)
        coefficients = np.linalg.lstsq(basis[known], values[known], rcond=None)[0]
        left = values[known] - basis[known] @ coefficients
        explained.append(1.0 - left.var() / values[known].var())
        squares = coefficients**2
        variance = sum(square for each, square in zip(powers, squares, strict=True) if any(each))
        found.append(
            [
                sum(
                    square
                    for each, square in zip(powers, squares, strict=True)
                    if each[i] > 0 and sum(each) == each[i]
                )
                / variance
                for i in range(count)
            ]
        )
    return np.array(found), np.array(explained)


def linear(study: SampledStudy) -> tuple[np.ndarray, np.ndarray]:
    """Indices and standard deviations to first order, from derivatives at the means."""
    result = stability(study.central, estimate_error=False)
    entries = parameter_sensitivities(result).entries
    steps = []
    for each in study.distributions:
        of = entries[each.name]
        slopes = (of.growth_rate, of.base.cell_velocity, of.base.effective_viscosity)
        steps.append(np.array(slopes) * each.standard_deviation)
    squares = np.array(steps).T ** 2
    variance = squares.sum(axis=1)
    return squares / variance[:, None], np.sqrt(variance)


def study(work: Path) -> None:
    """The page; the trains are computed in a folder in `work`."""
    page, folder = Page("uncertainty", "Trains of cells that differ"), work / "uncertainty"
    data = page.kept(DATA / "uncertainty.nc", lambda page: sample(page, STUDY, folder))
    case = make_sampled_study(STUDY)
    values = outputs(data)
    total, failed = values[0].size, int(np.isnan(values[0]).sum())
    found = estimated(values, indices=True)
    assert found.indices is not None
    assert found.low is not None
    assert found.high is not None
    words = "; ".join(
        f"{name}: {each.item()}"
        for name, each in zip(case.names, data["distribution"], strict=True)
    )
    page.text(
        f"""
Eight equal cells at D = 6, packing 0.2, whose volume differs from train to train by 12 % at
constant area (the reduced volume), and whose moduli differ by 30 %, each on its own. {words}.
{POINTS} Sobol points with {total // POINTS} trains each: {total} trains, {failed} failed. Errors
are those of resampling points.
"""
    )
    page.heading("Distribution")
    rows = []
    linear_indices, linear_deviation = linear(case)
    for i, name in enumerate(OUTPUTS.values()):
        rows.append(
            (
                name,
                _number(found.summary.mean[i], found.error.mean[i]),
                _number(found.summary.standard_deviation[i], found.error.standard_deviation[i]),
                f"{linear_deviation[i]:.2g}",
                *(
                    _number(*pair)
                    for pair in zip(found.summary.quantile[i], found.error.quantile[i], strict=True)
                ),
            )
        )
    head = ("", "mean", "standard deviation", "the same, linear")
    page.table((*head, "5 %", "25 %", "50 %", "75 %", "95 %"), rows)
    near = float(np.mean(np.abs(values[0]) < np.nanmax(data["error_estimate"].values)))
    unstable = _number(100.0 * found.summary.positive[0], 100.0 * found.error.positive[0])
    leading = data["leading_azimuthal_number"].values
    other = float(np.mean(leading[np.isfinite(leading)] != 1))
    errors = data["error_estimate"].values
    page.text(
        f"""
"Linear" is what the derivatives at the means give (`celltrain sensitivity`), an independent
computation. Unstable are {unstable} % of the trains; in {other:.1%} of all another mode than the
tilt, m = 1, is the fastest. The error of alpha by the degree is at most
{np.nanmax(errors):.0e} U/r0 in the {np.isfinite(errors).sum()} trains in which it was estimated,
far below the spread; {near:.1%} of the trains are within that of 0. The first bar of the histogram
are trains whose tilt hardly grows or decays: there some other, slow mode is the fastest.
"""
    )
    page.heading("Where the variance comes from")
    fit, explained = fitted(case, data)
    rows = []
    for k, name in enumerate(case.names):
        for i, output in enumerate(OUTPUTS.values()):
            first, whole = found.indices.first_order[i, k], found.indices.total_order[i, k]
            low, high = found.low.first_order[i, k], found.high.first_order[i, k]
            least, most = found.low.total_order[i, k], found.high.total_order[i, k]
            rows.append(
                (
                    name if i == 0 else "",
                    output.split(",")[0],
                    f"{first:.3f} ({low:.3f} to {high:.3f})",
                    f"{fit[i, k]:.3f}",
                    f"{linear_indices[i, k]:.3f}",
                    f"{whole:.3f} ({least:.3f} to {most:.3f})",
                )
            )
    page.table(
        ("parameter", "output", "first order (95 %)", "polynomial", "linear", "total (95 %)"), rows
    )
    inside = ((found.low.first_order <= fit) & (fit <= found.high.first_order)).sum()
    added = ", ".join(f"{each:.2f}" for each in found.indices.first_order.sum(axis=1))
    page.text(
        f"""
"Polynomial" are the first-order indices of Hermite polynomials up to degree {DEGREE} fitted to the
same trains, which explain {", ".join(f"{100 * each:.1f} %" for each in explained)} of the three
variances: another estimator, which assumes smoothness and has far smaller errors where that holds.
It lies within {inside} of the {fit.size} intervals. First-order indices add up to {added}; 1 would
be parameters that act independently of each other.
"""
    )
    rows = []
    for points in (POINTS // 4, POINTS // 2, POINTS):
        part = outputs(data, points)
        kept = part[:, :, np.isfinite(part).all(axis=(0, 1))]
        indices = sobol_indices(kept)
        change = np.abs(indices.first_order - fit).max()
        numbers = kept[0].ravel()
        rows.append(
            (
                points,
                part[0].size,
                f"{numbers.mean():.5f}",
                f"{numbers.std(ddof=1):.5f}",
                f"{change:.3f}",
            )
        )
    page.table(
        (
            "points",
            "trains",
            "mean of alpha",
            "its deviation",
            "largest difference of a first-order index from the polynomial's",
        ),
        rows,
    )
    seconds = data["processor_seconds"].values
    each = float(np.nanmean(seconds))
    low_end, high_end = np.nanquantile(seconds, [0.05, 0.95])
    sizes(page, found, folder)
    page.heading("What it costs")
    page.text(
        f"""
{each:.2f} s of processor time a train (mean over all; 5 to 95 %: {low_end:.2f} to {high_end:.2f}),
at the degree that alpha to 1 % asks for, measured while other programs shared the two cores.
{TRAINS} trains take {TRAINS * each / 60:.0f} minutes of processor time, so
{TRAINS * each / 120:.0f} minutes on two cores that do nothing else: half an hour is the aim.
"""
    )
    figure = plain_figure(10.0, 3.4)
    panels = figure.subplots(1, len(OUTPUTS))
    for i, (axes, (name, words)) in enumerate(zip(panels, OUTPUTS.items(), strict=True)):
        axes.hist(data[name].values.ravel(), bins=28, color="#56B4E9", edgecolor="white")
        axes.axvline(found.summary.mean[i], color="0.2", linewidth=1.2)
        shares = ", ".join(
            f"${symbol(TAKEN[parameter])}$ {found.indices.first_order[i, k]:.2f}"
            for k, parameter in enumerate(case.names)
        )
        axes.set_title(shares, loc="left", fontsize=9)
        axes.set_xlabel(words)
        axes.locator_params(axis="x", nbins=5)
    panels[0].set_ylabel("trains")
    page.figure(figure, "Trains of cells that differ; above, the first-order indices")
    page.write()


def sizes(page: Page, shapes: WithErrors, folder: Path) -> None:
    """The same for cells of one shape, computed in the folder."""
    data = page.kept(DATA / "uncertainty-sizes.nc", lambda page: sample(page, SIZES, folder))
    case = make_sampled_study(SIZES)
    values = outputs(data)
    found = estimated(values, indices=True)
    assert found.indices is not None
    page.heading("Volume as size")
    page.text(
        f"""
A cell's volume may also differ at the same shape. In SI, with the radius r0 drawn (lognormal, 4 %,
which is 12 % of the volume) in place of the reduced volume, tube, mean velocity and packing
fraction kept, and the moduli as before: {values[0].size} trains,
{int(np.isnan(values[0]).sum())} failed. Deviations are over the mean, in brackets those above.
"""
    )
    rows = []
    for i, name in enumerate(OUTPUTS):
        mean, deviation = found.summary.mean[i], found.summary.standard_deviation[i]
        error = found.error.standard_deviation[i]
        other = shapes.summary.standard_deviation[i] / shapes.summary.mean[i]
        rows.append(
            (
                f"{OUTPUTS[name].split(',')[0]}, {data[name].attrs['units']}",
                _number(mean, found.error.mean[i]),
                f"{_number(100 * deviation / mean, 100 * error / mean)} % ({100 * other:.2f} %)",
                *(f"{each:.2f}" for each in found.indices.first_order[i]),
            )
        )
    page.table(("", "mean", "deviation", *(f"first order: {name}" for name in case.names)), rows)


def _number(value: float, error: float) -> str:
    digits = max(0, 1 - int(np.floor(np.log10(error)))) if error > 0.0 else 5
    return f"{value:.{digits}f} ± {error:.{digits}f}"
