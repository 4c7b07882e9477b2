"""Capsules in unbounded shear, by numbers that others have published.

One capsule is that of `capsule_shear`, with its moduli and units; here two of them cross.
"""

import capsule_evidence
import capsule_shear
import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import xarray as xr
from capsule_shear import COARSER, DEGREE, PUBLISHED, READING, on_curve, published
from page import FOLDER, Page, plain_figure

from celltrain.diagnostics import cell_moments
from celltrain.evolution import CellsInFlow, Repulsion, RungeKuttaChebyshev, Snapshot, follow
from celltrain.harmonics import displaced
from celltrain.membrane.energy import Membrane
from celltrain.parameters import Cell, Resolution
from celltrain.surroundings import simple_shear

ONE, TWO, CHECKS = (FOLDER / "data" / f"capsules-{name}.nc" for name in ("one", "two", "checks"))
#: What reading a printed curve may be wrong by, in an offset over 2a, and the final one as printed.
OFFSET_READING, FINAL_OFFSET = 0.01, 0.546
FINER = 16
#: Two capsules: mu k a/Gs, inflation, and where the second is seen from the first, in 2a.
CROSSING, INFLATION, APART = 0.45, 0.05, (-4.0, 0.25)


@eqx.filter_jit
def _centroids(membrane: Membrane, shapes: jax.Array) -> jax.Array:
    return jax.vmap(lambda shape: cell_moments(membrane, shape).centroid)(shapes)


def crossing(
    degree: int = DEGREE,
    tolerance: float = 1e-3,
    strength: float = CROSSING,
    inflation: float = INFLATION,
) -> xr.DataArray:
    """Relative place (x, y)/(2a) of two capsules that pass each other, in steps of k t = 1/4."""
    radius = 1.0 + inflation
    cell = Cell(
        reference="sphere",
        law="neo_hookean",
        shear_modulus=2.0 * radius / strength,
        bending_modulus=0.0,
    )
    cells = CellsInFlow(
        cell, simple_shear(1.0), Resolution(degree=degree), repulsion=Repulsion(range=0.0)
    )
    membrane = cells.operator(close=False).membrane
    half = radius * np.array([*APART, 0.0])
    shapes = displaced(radius * cells.resting([(0.0, 0.0, 0.0)] * 2), np.stack([half, -half]))
    places: list[np.ndarray] = []
    method = RungeKuttaChebyshev(tolerance=tolerance)
    for each in follow(cells, shapes, until=40.0, every=0.25, integrator=method):
        places.append(_apart(membrane, each) / (2.0 * radius))
        if places[-1][0] > 6.0:
            break
    return xr.DataArray(np.array(places)[:, :2], dims=("step", "axis"))


def _apart(membrane: Membrane, snapshot: Snapshot) -> np.ndarray:
    first, second = np.asarray(_centroids(membrane, jnp.asarray(snapshot.shapes)))
    return np.asarray(first - second)


def compute_two(page: Page) -> xr.Dataset:
    """Paths of two capsules, and how they change with degree, steps and inflation."""
    found: dict[str, xr.DataArray] = {}
    for name, arguments in (
        ("crossing", {}),
        ("crossing_coarser", {"degree": COARSER}),
        ("crossing_steps", {"degree": COARSER, "tolerance": 1e-4}),
        ("crossing_finer", {"degree": FINER}),
        ("crossing_not_inflated", {"inflation": 0.0}),
    ):
        page.log(name)
        curve = crossing(**arguments)  # type: ignore[arg-type]
        found[name] = curve.rename(step=f"step_{name}")
    return xr.Dataset(found)


def offsets(data: xr.Dataset, name: str, x: np.ndarray) -> np.ndarray:
    """A computed y/(2a) where the capsules are x/(2a) apart along the flow."""
    places = data[name].values
    return np.interp(x, places[:, 0], places[:, 1])


def study() -> None:
    page = Page("capsules", "Capsules in unbounded shear, by published numbers")
    one, two = page.kept(ONE, capsule_shear.compute_one), page.kept(TWO, compute_two)
    checks = page.kept(CHECKS, capsule_evidence.compute_checks)
    page.text(
        f"""
Spherical capsules of radius a in the flow u = k y e_x, the same fluid inside and outside unless
stated, by the operator for cells of any shape in unbounded space (`celltrain.surroundings`) and
marched by `celltrain.evolution.follow`. D = (l - b)/(l + b), with l and b the longest and shortest
axis of the ellipsoid with the capsule's second moments. Membranes are neo-Hookean without bending
unless stated; Gs is the shear modulus at small strain, here Es/2. Degree {DEGREE}, steps with the
usual tolerance. The published points were read off printed curves (`data/{PUBLISHED.name}`), which
may be wrong by about {READING:g} in D and {OFFSET_READING:g} in an offset. What is computed
is kept in `data/{ONE.name}`, `data/{TWO.name}` and `data/{CHECKS.name}`; remove them to have it
anew, in 10 to 30 minutes.
"""
    )
    capsule_shear.small_deformation(page, one)
    capsule_shear.large_deformation(page, one)
    capsule_evidence.section(page, one, checks)
    crossing_capsules(page, two)
    draw(page, one, two, checks)
    page.write()


def crossing_capsules(page: Page, data: xr.Dataset) -> None:
    """Two capsules, by the offset with which they part."""
    page.heading("Two capsules that cross")
    page.text(
        f"""
mu k a/Gs = {CROSSING:g}; inflated by {100 * INFLATION:g} % (a = {1 + INFLATION:g} times the radius
at rest), which keeps the membranes in tension; the second capsule begins at
({APART[0]:g}, {APART[1]:g}) 2a from the first, in the plane of the shear. No repulsion acts.
Expected: the path in Fig. 4b of Lac, Morel & Barthes-Biesel (2007), with the final offset
{FINAL_OFFSET:g} in 2a.
"""
    )
    points = published()["crossing"]
    rows = []
    for name, label in (
        ("crossing", f"degree {DEGREE}"),
        ("crossing_coarser", f"degree {COARSER}"),
        ("crossing_steps", f"degree {COARSER}, a tenth of the tolerance of steps"),
        ("crossing_finer", f"degree {FINER}"),
        ("crossing_not_inflated", f"degree {DEGREE}, not inflated"),
    ):
        found = offsets(data, name, points[:, 0]) - points[:, 1]
        final = float(offsets(data, name, points[-1:, 0])[0])
        rows.append(
            (
                label,
                f"{offsets(data, name, np.linspace(-2, 3, 501)).max():.4f}",
                f"{final:.4f}",
                f"{final - FINAL_OFFSET:+.4f}",
                f"{np.abs(found).max():.4f}",
                "yes" if np.abs(found).max() <= OFFSET_READING else "no",
            )
        )
    page.table(
        (
            "",
            "largest offset",
            "final offset",
            "difference",
            "largest difference from the path",
            "within the reading",
        ),
        rows,
    )


def draw(page: Page, one: xr.Dataset, two: xr.Dataset, checks: xr.Dataset) -> None:
    """D over time, and the path of two capsules."""
    figure = plain_figure(9.0, 3.9)
    left, right = figure.subplots(1, 2)
    styles = {
        "neo_hookean_0.05": ("C0", "Ca = 0.05"),
        "neo_hookean_0.1": ("C1", "Ca = 0.1"),
        "neo_hookean_0.2": ("C2", "Ca = 0.2"),
        "bending_0.05": ("C3", "Ca = 0.05, bending moments"),
        "bending_0.05_energy": ("C4", "Ca = 0.05, bending energy"),
    }
    for name, (colour, label) in styles.items():
        times = one[f"time_{name}"].values
        left.plot(times, on_curve(one, name, times), color=colour, label=label)
        if name in published():
            left.plot(*published()[name].T, "o", color=colour, markersize=3, fillstyle="none")
        finest = name.replace("neo_hookean", "triangles") + f"_{max(capsule_evidence.PARTS)}"
        if finest in checks:
            curve = checks[finest][::5]
            left.plot(curve["time"], curve, "x", color=colour, markersize=4)
    left.set(xlabel="$k\\,t$", ylabel="$D$", xlim=(0, 8), ylim=(0, 0.72))
    left.legend(frameon=False, fontsize=8, ncols=2, loc="upper left")
    for name, style, label in (
        ("crossing", "C0-", f"inflated by {100 * INFLATION:g} %"),
        ("crossing_not_inflated", "C1--", "not inflated"),
    ):
        right.plot(*two[name].values.T, style, label=label)
    right.plot(*published()["crossing"].T, "ko", markersize=3, fillstyle="none", label="published")
    right.set(xlabel="$x/(2a)$", ylabel="$y/(2a)$", xlim=(-4.2, 6.2), ylim=(0.2, 0.8))
    right.legend(frameon=False, fontsize=8, loc="upper left")
    page.figure(
        figure,
        "Left: deformation of one capsule; circles: published, crosses: the second method. Right:"
        " path of one of two capsules as seen from the other",
    )
