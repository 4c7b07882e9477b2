"""One capsule in unbounded shear: its deformation over time, beside published curves.

Spherical capsules of radius a in u = k y e_x, with viscosity mu inside and outside. A neo-Hookean
membrane of the shear modulus Gs is here one of the modulus Es = 2 Gs; published capillary numbers
are mu k a/Es with Es = 3 Gs (Ramanujan & Pozrikidis, Pozrikidis), or mu k a/Gs (Lac and others).
Lengths are in r0, the radius at rest, and velocities in k r0.
"""

import json
from dataclasses import dataclass, field
from functools import cache

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import xarray as xr
from page import FOLDER, Page

from celltrain.diagnostics import best_ellipsoid, cell_moments
from celltrain.evolution import CellsInFlow, RungeKuttaChebyshev, follow
from celltrain.harmonics import surface_points
from celltrain.membrane.energy import Membrane
from celltrain.parameters import Cell, Resolution
from celltrain.surroundings import simple_shear

PUBLISHED = FOLDER / "data" / "capsules-published.json"
#: What reading a printed curve may be wrong by, in D.
READING = 0.003
#: Plateaus as printed.
PLATEAUS = {0.05: 0.261, 0.1: 0.384, 0.2: 0.500}
DEGREE, COARSER = 12, 8
SLOPE = 25.0 / 12.0
MEASURES = ["ellipsoid", "distances"]
#: Bending modulus over a^2 Es.
BENDING = 0.0375
#: mu k a/Gs of the small deformation, and a time when it has settled: many times 25/6 of it.
SMALL, SETTLED = 0.002, 0.25


@dataclass(frozen=True)
class Shear:
    """One capsule: mu k a/Gs, its membrane, and how it is computed."""

    strength: float
    until: float
    cell: dict[str, object] = field(default_factory=dict)
    degree: int = DEGREE
    tolerance: float = 1e-3
    viscosity_ratio: float = 1.0

    def deformations(self, every: float = 0.1) -> xr.DataArray:
        """D over k t, by the ellipsoid of inertia and by distances from the centre."""
        modulus = 2.0 / self.strength
        cell = {"law": "neo_hookean", "shear_modulus": modulus, "bending_modulus": 0.0, **self.cell}
        cells = CellsInFlow(
            Cell(reference="sphere", **cell),  # type: ignore[arg-type]
            simple_shear(1.0),
            Resolution(degree=self.degree),
            self.viscosity_ratio,
        )
        membrane = cells.operator(close=False).membrane
        method = RungeKuttaChebyshev(tolerance=self.tolerance)
        marched = list(
            follow(
                cells,
                cells.resting([(0.0, 0.0, 0.0)]),
                until=self.until,
                every=every,
                integrator=method,
            )
        )
        found = [_deformations(membrane, jnp.asarray(each.shapes[0])) for each in marched]
        times = [each.time for each in marched]
        return xr.DataArray(np.array(found).T, {"measure": MEASURES, "time": times})


@eqx.filter_jit
def _deformations(membrane: Membrane, shape: jax.Array) -> jax.Array:
    moments = cell_moments(membrane, shape)
    points = surface_points(shape, membrane.tables.value) - moments.centroid
    distances = jnp.linalg.norm(points, axis=1)
    least, largest = jnp.min(distances), jnp.max(distances)
    by_distances = (largest - least) / (largest + least)
    return jnp.stack([best_ellipsoid(moments.solid).taylor_deformation, by_distances])


def shear_cases() -> dict[str, Shear]:
    """The capsules of the published curves, by the curves' names."""
    cases = {
        f"neo_hookean_{number:g}": Shear(3.0 * number, until)
        for number, until in ((0.05, 5.0), (0.1, 8.0), (0.2, 8.0))
    }
    for name, bending in (("bending_0.05", "moments"), ("bending_0.05_energy", "elastic")):
        modulus = {"bending": bending, "bending_modulus": BENDING / 0.05}
        cases[name] = Shear(3.0 * 0.05, 2.0, modulus)
    return cases


def compute_one(page: Page) -> xr.Dataset:
    """Curves of one capsule, and how they change with degree and steps."""
    found: dict[str, xr.DataArray] = {}
    for name, case in shear_cases().items():
        for suffix, change in (
            ("", {}),
            ("_coarser", {"degree": COARSER}),
            ("_steps", {"degree": COARSER, "tolerance": 1e-4}),
        ):
            page.log(f"{name}{suffix}")
            curve = Shear(**{**vars(case), **change}).deformations()
            found[name + suffix] = curve.rename(time=f"time_{name}{suffix}")
    for ratio in (0.2, 1.0, 5.0):
        for law in ("neo_hookean", "skalak"):
            page.log(f"small deformation, {law}, viscosity ratio {ratio:g}")
            cell = {"law": law, "dilatation_modulus": 2.0 / SMALL}
            case = Shear(SMALL, SETTLED, cell, COARSER, 1e-4, ratio)
            last = case.deformations(every=SETTLED)[0, -1]
            found[f"small_{law}_{ratio:g}"] = xr.DataArray(float(last))
    return xr.Dataset(found)


@cache
def published() -> dict[str, np.ndarray]:
    """Points of the published curves, [point, 2]."""
    kept = json.loads(PUBLISHED.read_text())
    return {name: np.array(curve["points"]) for name, curve in kept.items()}


def on_curve(
    data: xr.Dataset, name: str, times: np.ndarray, measure: str = "ellipsoid"
) -> np.ndarray:
    """A computed D at other times."""
    values = data[name].sel(measure=measure).values
    return np.interp(times, data[f"time_{name}"].values, values)


def change(data: xr.Dataset, name: str) -> float:
    """Largest change of D by the degree, or by the steps."""
    times = data[f"time_{name}"].values
    others = (on_curve(data, f"{name}_{each}", times) for each in ("coarser", "steps"))
    coarser, steps = others
    by_degree = np.abs(on_curve(data, name, times) - coarser).max()
    return float(by_degree + np.abs(steps - coarser).max())


def small_deformation(page: Page, data: xr.Dataset) -> None:
    """The slope of D at small capillary numbers."""
    page.heading("Small deformation")
    page.text(
        f"""
To first order D = 25/12 mu k a/Gs, whatever the viscosity ratio, for the neo-Hookean law and for
Skalak's with C = Ed/Es = 1 (Barthes-Biesel & Rallison 1981). Simulated at mu k a/Gs = {SMALL:g},
degree {COARSER}; the table shows D/(mu k a/Gs), expected {SLOPE:.5f} but for what is of second
order in the flow's strength times the viscosity ratio.
"""
    )
    page.table(
        ("viscosity ratio", "neo-Hookean", "error", "Skalak, C = 1", "error"),
        [
            (f"{ratio:g}", *cells)
            for ratio in (0.2, 1.0, 5.0)
            for cells in [
                tuple(
                    text
                    for law in ("neo_hookean", "skalak")
                    for slope in [float(data[f"small_{law}_{ratio:g}"]) / SMALL]
                    for text in (f"{slope:.5f}", f"{slope / SLOPE - 1.0:.0e}")
                )
            ]
        ],
    )


def large_deformation(page: Page, data: xr.Dataset) -> None:
    """D over time beside the published curves."""
    page.heading("One capsule")
    page.text(
        f"""
Ca = mu k a/Es with Es = 3 Gs: mu k a/Gs = 3 Ca. Expected: the curves of Ramanujan & Pozrikidis
(1998), and of Pozrikidis (2001) with bending, Eb = {BENDING} a^2 Es, which has bending moments
(`bending = "moments"`; beside them the energy `elastic` with the same modulus). The published value
is the mean of the last quarter of the points, the computed one is at the same times, and the
largest difference is over all points from k t = 0.2 on. The error is what degree and steps change
at most: degree {COARSER} in place of {DEGREE}, and steps with a tenth of the tolerance.
"""
    )
    rows = []
    names = {
        **{f"neo_hookean_{ca:g}": f"Ca = {ca:g}" for ca in (0.05, 0.1, 0.2)},
        "bending_0.05": "Ca = 0.05, moments",
        "bending_0.05_energy": "Ca = 0.05, elastic",
    }
    for name, label in names.items():
        points = published()[name.removesuffix("_energy")]
        points = points[points[:, 0] <= float(data[f"time_{name}"][-1])]
        last = points[-(-3 * len(points) // 4) :]
        found = on_curve(data, name, points[:, 0]) - points[:, 1]
        late = points[:, 0] >= 0.2
        expected, value = last[:, 1].mean(), on_curve(data, name, last[:, 0]).mean()
        rows.append(
            (
                label,
                f"{value:.4f}",
                f"{change(data, name):.4f}",
                f"{expected:.4f}",
                f"{value - expected:+.4f}",
                f"{100.0 * (value / expected - 1.0):+.1f} %",
                f"{np.abs(found[late]).max():.4f}",
                "yes" if np.abs(found[late]).max() <= READING else "no",
            )
        )
    page.table(
        (
            "",
            "D, late",
            "its error",
            "published",
            "difference",
            "relative",
            "largest difference",
            "within the reading",
        ),
        rows,
    )
