"""What the paper says about its maps over diameter and packing, and whether ours say the same.

Bryngelson & Freund, Phys. Rev. Fluids 3, 073101 (2018), Sec. V B; the statements are in our words,
their names P6 ... P12 only tell them apart. Rates are in the paper's unit (`paper_units`).
"""

import math

import numpy as np
import xarray as xr

from celltrain.paper.finding import DENSE, SPARSE, Finding, at, finding, first_case, in_paper_units

#: What "about 0.1" may mean: the printed colours and contours tell no more.
ABOUT_A_TENTH = (0.03, 0.2)
#: What "about four" may mean.
ABOUT_FOUR = (3.0, 5.0)
#: Where the paper finds trains that are marginally stable: packings, and the largest diameter.
WINDOW = (0.4, 0.55)
WINDOW_DIAMETER = 10.0
MARGINAL = 1e-3
#: Largest packing, and the distance in r0, of the paper's summary.
STABLE_UP_TO, FAR = 0.6, 1e5
#: Contours of eta that the paper draws.
CONTOURS = (40.0, 52.0)
#: Least and largest azimuthal number m of what is not axisymmetric.
ASYMMETRIC = (1, math.inf)


def growth_findings(data: xr.Dataset) -> list[Finding]:
    """The statements about the growth rate alpha (Fig. 6) beside a study over both parameters."""
    alpha = in_paper_units(data["spectral_abscissa"])
    error = in_paper_units(data["error_estimate"])
    half = first_case(data).cells // 2
    sparse, dense = at(alpha, packing=SPARSE), at(alpha, packing=DENSE)
    window = alpha.where(
        (alpha.packing >= WINDOW[0] - 1e-9)
        & (alpha.packing <= WINDOW[1] + 1e-9)
        & (alpha.diameter <= WINDOW_DIAMETER + 1e-9),
        drop=True,
    )
    largest = float(window.max(skipna=False)) if window.size else np.nan
    return [
        finding(
            "P6",
            "at packing 0.2 alpha is about 0.1 at every diameter",
            _list(sparse, at(error, packing=SPARSE)),
            _inside(sparse, ABOUT_A_TENTH),
            sparse,
        ),
        finding(
            "P6",
            "at packing 0.2 alpha is smaller in wider tubes",
            f"from {_first(sparse):.3f} to {_last(sparse):.3f}",
            _last(sparse) < _first(sparse),
            sparse,
        ),
        finding(
            "P7",
            "at packing 0.7 alpha is about 0.1 at every diameter",
            _list(dense, at(error, packing=DENSE)),
            _inside(dense, ABOUT_A_TENTH),
            dense,
        ),
        finding(
            "P8",
            f"alpha is below {MARGINAL:g} from packing {WINDOW[0]:g} to {WINDOW[1]:g} in tubes up"
            f" to {WINDOW_DIAMETER:g} r0 wide",
            f"largest of {window.size}: {largest:.1e}",
            largest < MARGINAL,
            window,
        ),
        _pattern(data, "P9", "leading", SPARSE, (1, 1), 0, "tilts all cells alike"),
        _pattern(data, "P9", "leading", DENSE, (1, 1), half, "is a wave of two cells"),
    ]


def distance_findings(data: xr.Dataset) -> list[Finding]:
    """How far trains flow before a disturbance grows a thousandfold (Sec. VI), by the same study.

    U_c ln(1000)/alpha: the paper's distances are those of the centre line.
    """
    chosen = data.where(
        (data.packing >= WINDOW[0] - 1e-9)
        & (data.packing <= STABLE_UP_TO + 1e-9)
        & (data.diameter <= WINDOW_DIAMETER + 1e-9),
        drop=True,
    )
    alpha = chosen["spectral_abscissa"]
    ways = (chosen["cell_velocity"] * math.log(1e3) / alpha).where(alpha > 0.0, math.inf)
    shortest = float(ways.min()) if ways.size else math.nan
    return [
        finding(
            "P32",
            "packing 0.4 to 0.6, D up to 10: at least 1e5 r0 before a thousandfold growth",
            f"the shortest of {ways.size}: {shortest:.1e} r0; {int((ways > FAR).sum())} go farther"
            " than 1e5 r0",
            shortest > FAR,
            alpha,
        )
    ]


def transient_findings(data: xr.Dataset) -> list[Finding]:
    """The statements about the initial growth rate eta (Fig. 8) beside the same study."""
    eta = in_paper_units(data["numerical_abscissa"])
    cells = first_case(data).cells
    least, most = float(eta.min(skipna=False)), float(eta.max(skipna=False))
    corners = (float(eta.isel(diameter=0, packing=0)), float(eta.isel(diameter=-1, packing=-1)))
    findings = [
        finding(
            "P11",
            "eta varies by about four over the map",
            f"{least:.1f} to {most:.1f}: {most / least:.2f}",
            ABOUT_FOUR[0] < most / least < ABOUT_FOUR[1],
            eta,
        ),
        finding(
            "P11",
            "eta rises with diameter and packing",
            f"{corners[0]:.1f} in the narrowest tube with the sparsest train, {corners[1]:.1f} in"
            f" the widest with the densest; {_rising(eta):.0%} of all steps rise",
            least < most and corners == (least, most),
            eta,
        ),
        *(
            finding(
                "P11",
                f"the contour eta = {contour:g} crosses the map",
                f"{least:.1f} to {most:.1f}",
                least < contour < most,
                eta,
            )
            for contour in CONTOURS
        ),
        _pattern(
            data,
            "P12",
            "transient",
            SPARSE,
            ASYMMETRIC,
            cells // 2,
            "is a wave of two cells and not axisymmetric",
        ),
    ]
    for diameter, allowed, words in (
        (6.0, ASYMMETRIC, "not axisymmetric"),
        (10.0, (0, 0), "axisymmetric"),
    ):
        findings.append(
            _pattern(
                data,
                "P12",
                "transient",
                DENSE,
                allowed,
                cells // 4,
                f"is a wave of four cells and {words}",
                diameter,
            )
        )
    return findings


def _inside(values: xr.DataArray, limits: tuple[float, float]) -> bool:
    return bool(((values > limits[0]) & (values < limits[1])).all())


def _first(values: xr.DataArray) -> float:
    return float(values[0]) if values.size else np.nan


def _last(values: xr.DataArray) -> float:
    return float(values[-1]) if values.size else np.nan


def _list(values: xr.DataArray, errors: xr.DataArray) -> str:
    """Values, each with its error if that is known: ``0.118 (17)`` has the error 0.017."""
    return ", ".join(
        f"{value:.3f}" + (f" ({1e3 * error:.0f})" if np.isfinite(error) else "")
        for value, error in zip(values.values, errors.values, strict=True)
    )


def _rising(values: xr.DataArray) -> float:
    """Share of the steps from case to neighbouring case, along either axis, that rise."""
    steps = np.concatenate([np.diff(values.values, axis=axis).ravel() for axis in (0, 1)])
    return float(np.mean(steps > 0)) if steps.size else np.nan


def _pattern(
    data: xr.Dataset,
    name: str,
    kind: str,
    packing: float,
    numbers: tuple[float, float],
    wave_number: int,
    words: str,
    diameter: float | None = None,
) -> Finding:
    """Whether a disturbance has an azimuthal number m within limits, and its wave number j."""
    number = at(data[f"{kind}_azimuthal_number"], packing=packing)
    wave = at(data[f"{kind}_wave_number"], packing=packing)
    where = "at every diameter"
    if diameter is not None:
        chosen = np.isclose(number.diameter, diameter)
        number, wave = number[chosen], wave[chosen]
        where = f"at diameter {diameter:g}"
    places = {
        f"m = {m:g}, j = {j:g}": None for m, j in zip(number.values, wave.values, strict=True)
    }
    disturbance = "leading mode" if kind == "leading" else "disturbance that grows fastest at first"
    holds = ((number >= numbers[0]) & (number <= numbers[1]) & (wave == wave_number)).all()
    return finding(
        name,
        f"at packing {packing:g} {where} the {disturbance} {words}",
        "; ".join(places),
        holds,
        number,
    )
