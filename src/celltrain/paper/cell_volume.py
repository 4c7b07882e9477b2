"""Reduced volume of the cells: Figs. 17 and 19, and the paper's statements (Sec. V E)."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from celltrain.harmonics import profile_of
from celltrain.membrane.equilibrium import contact_volume, relaxed_shape
from celltrain.membrane.relaxation import REPULSION_RANGE, relaxation
from celltrain.meridian.geometry import meridian_points
from celltrain.paper.curves import side_by_side, sparse_and_dense
from celltrain.paper.finding import DENSE, SPARSE, Finding, at, finding, in_paper_units, number
from celltrain.paper.resolutions import PAPER, Resolutions, Style, best, present

#: Reduced volumes of the drawn family; the healthy cell's is 0.6444.
FAMILY = (0.4, 0.5, 0.6, 0.6444, 0.7, 0.8, 0.9, 1.0)
HEALTHY = 0.6444
#: The degree of the family that has converged: points move by 1e-3 r0 from here on.
DEGREE = 24
#: Where the paper needs a repulsion while shapes form, and how exactly we read that.
REPELLED_BELOW, LEEWAY = 0.61, 0.02
#: The most unstable reduced volume at packing 0.2 by diameter; the largest of a dense train.
MOST_UNSTABLE, MOST_LEEWAY = {8.0: 0.55, 12.0: 0.52}, 0.03
LARGEST, LARGEST_LEEWAY = 0.86, 0.03


def family(degree: int | None) -> xr.Dataset:
    """Meridians of the family of shapes at rest, in r0, and how close their faces come."""
    degree = DEGREE if degree is None else degree
    problem = relaxation(degree)
    shapes = [profile_of(relaxed_shape(degree, v)) for v in FAMILY]
    profiles = np.stack([np.stack(meridian_points(shape, 401)) for shape in shapes])
    unknowns = [problem.unknowns(shape) for shape in shapes]
    held = np.array([problem.held(each) for each in unknowns])
    thickness = [problem.least_thickness(each) for each in unknowns]
    return xr.Dataset(
        {
            "profile": (("reduced_volume", "axis", "point"), profiles),
            "area": ("reduced_volume", held[:, 0]),
            "volume": ("reduced_volume", held[:, 1]),
            "thickness": ("reduced_volume", thickness),
            "contact": contact_volume(degree),
        },
        coords={"reduced_volume": list(FAMILY), "axis": ["distance", "height"]},
        attrs={"title": "shapes at rest of reduced volumes", "degree": degree},
    )


def draw_family(data: Resolutions) -> Figure:
    """Fig. 17: the shapes at rest, cut along their axes; dotted at the paper's degree."""
    figure, [axes] = side_by_side(1)
    figure.set_size_inches(8.0, 3.4)
    axes.set_title("")
    for place, v in enumerate(FAMILY):
        # The axis upright, the cells beside each other.
        column, row = place % 4, place // 4
        x, y = 3.4 * column, -2.9 * row
        for name, each in present(data):
            distance, height = each["profile"].sel(reduced_volume=v).values
            style: Style = {"ec": "k", "lw": 1.0, "fc": "0.9" if v != HEALTHY else "lightcoral"}
            if name == PAPER and len(data) > 1:
                style = {"ec": "C0", "lw": 1.0, "ls": ":", "fc": "none"}
            axes.fill(
                np.concatenate([x + distance, x - distance[::-1]]),
                np.concatenate([y + height, y + height[::-1]]),
                **style,
            )
        axes.text(x, y - 1.25, f"$v$ = {v:.2f}", ha="center", va="top", fontsize=9)
    axes.set_aspect("equal")
    axes.plot([-1.5, -0.5], [1.3, 1.3], "k-", linewidth=2)
    axes.text(-1.0, 1.35, "$r_0$", ha="center", va="bottom", fontsize=9)
    axes.axis("off")
    return figure


def family_findings(data: xr.Dataset) -> list[Finding]:
    """The statement about the shapes at rest (Fig. 17)."""
    v = data["volume"] / (4 * np.pi / 3 * (data["area"] / (4 * np.pi)) ** 1.5)
    wrong = float(abs(v - v.reduced_volume).max())
    contact, least = float(data["contact"]), float(data["thickness"].min())
    repelled = data.reduced_volume[data["thickness"] < REPULSION_RANGE]
    return [
        finding(
            "P26",
            "there are equilibrium shapes for reduced volumes from 0.4 to 1",
            f"all of {v.size}, reduced volumes right to {wrong:.0e}; thinnest {least:.3f} r0",
            wrong < 1e-6 and least > 0.0,
            v,
        ),
        finding(
            "P26",
            f"no reduced volume above {REPELLED_BELOW:g} needs a repulsion while the shape forms",
            f"faces keep {REPULSION_RANGE:g} r0, the range of ours, apart in all shapes but v ="
            f" {', '.join(f'{float(each):g}' for each in repelled)}",
            float(repelled.max()) < REPELLED_BELOW,
            repelled,
        ),
        finding(
            "P26",
            f"all shapes of reduced volumes below {REPELLED_BELOW:g} need it",
            f"without it, the faces meet below {contact:.3f}",
            abs(contact - REPELLED_BELOW) < LEEWAY,
            [contact],
        ),
    ]


def draw_over_volume(data: Resolutions) -> Figure:
    """Fig. 19: alpha over the reduced volume for sparse and dense trains, in the paper's unit."""
    figure, panels = sparse_and_dense(data, "reduced_volume", HEALTHY)
    for axes in panels:
        axes.set(xlabel="$v$", xlim=(0.38, 1.0))
    last = _last(at(best(data)["spectral_abscissa"], packing=DENSE))
    if np.isfinite(last):
        panels[1].axvspan(last, 1.0, color="0.9")
    return figure


def volume_findings(data: xr.Dataset) -> list[Finding]:
    """The statements about the reduced volume (Fig. 19)."""
    alpha, error = (in_paper_units(data[name]) for name in ("spectral_abscissa", "error_estimate"))
    found = []
    for diameter in alpha.diameter.values:
        thin = at(alpha, diameter=diameter, packing=SPARSE)
        place, height = _peak(thin.dropna("reduced_volume"))
        expected = MOST_UNSTABLE.get(float(diameter))
        if expected is not None:
            bars = at(error, diameter=diameter, packing=SPARSE)
            found.append(
                finding(
                    "P27",
                    f"D = {diameter:g}, packing {SPARSE:g}: the most unstable reduced volume is"
                    f" about {expected:g}",
                    f"{place:.3f}, alpha {number(height, bars.max())}; among"
                    f" {int(np.isfinite(thin).sum())} of {thin.size} volumes with a train",
                    abs(place - expected) < MOST_LEEWAY,
                    [place],
                )
            )
        thick = at(alpha, diameter=diameter, packing=DENSE).dropna("reduced_volume")
        steps = np.diff(thick.values) > 0.0
        ends = (
            f"from {number(thick[0])} at {float(thick.reduced_volume[0]):.3g} to"
            f" {number(thick[-1])} at {float(thick.reduced_volume[-1]):.3g}"
            if thick.size
            else ""
        )
        found.append(
            finding(
                "P28",
                f"D = {diameter:g}, packing {DENSE:g}: alpha rises monotonically with the volume",
                f"{int(steps.sum())} of {steps.size} steps rise, {ends}",
                steps.all(),
                thick if thick.size > 1 else [],
            )
        )
    thick = at(alpha, packing=DENSE)
    both = thick.dropna("reduced_volume")
    smaller = both.isel(diameter=-1) < both.isel(diameter=0)
    last = _last(thick)
    none = thick.isnull().all("diameter") & (thick.reduced_volume > last)
    largest = [float(v) for v in thick.reduced_volume[none]]
    found += [
        finding(
            "P28",
            f"packing {DENSE:g}: alpha is smaller in the widest tube than in the narrowest",
            f"at {int(smaller.sum())} of {smaller.size} volumes",
            smaller.all(),
            both,
        ),
        finding(
            "P28",
            f"packing {DENSE:g}: no train without overlap of a reduced volume above {LARGEST:g}",
            f"the largest with a train is {last:.3g}, the next ones that have none are"
            f" {', '.join(f'{v:.3g}' for v in largest) or 'not tried'}",
            bool(largest) and last - LARGEST_LEEWAY < LARGEST < min(largest) + 1e-9,
            # Not known unless larger ones were tried.
            [last] if largest else [],
        ),
    ]
    return found


def _last(values: xr.DataArray) -> float:
    """The largest reduced volume with a number at any diameter; nan if there is none."""
    known = values.notnull().any("diameter")
    return float(values.reduced_volume[known].max()) if known.any() else np.nan


def _peak(values: xr.DataArray) -> tuple[float, float]:
    """Place and height of a curve's maximum, by the parabola through its largest value."""
    if values.size < 3:
        return np.nan, np.nan
    x, y = values.reduced_volume.values, values.values
    top = int(y.argmax())
    if top in (0, len(x) - 1):
        return float(x[top]), float(y[top])
    around = slice(top - 1, top + 2)
    curve = np.polynomial.Polynomial.fit(x[around], y[around], 2)
    place = float(np.real(curve.deriv().roots()[0]))
    return place, float(curve(place))
