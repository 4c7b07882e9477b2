"""Growth rates over the degree where the paper and we differ: is it the resolution?

The numbers are kept in docs/validation/data/disputed.nc; cases that the file lacks are computed.
"""

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from degrees import LADDER
from matplotlib.axes import Axes
from page import FOLDER, Page, plain_figure

from celltrain import Base, CaseError, NotConverged, Train, steady
from celltrain.parameters import paper_units
from celltrain.results import write_dataset
from celltrain.stability.convergence import ACCURACY, LEAST_ERROR
from celltrain.stability.linearise import linear_blocks
from celltrain.stability.neutral import neutral_space
from celltrain.stability.spectrum import growing_eigenvalues
from celltrain.steady.degree import Convergence

FILE = FOLDER / "data" / "disputed.nc"
CELLS = 8
#: Azimuthal numbers that are looked at: in strong flow those up to 8 lead.
MOST_AZIMUTHAL = 8
#: Numbers of each case and degree, with their units.
NUMBERS = {
    "alpha": ("U/r0", "largest growth rate"),
    "frequency": ("U/r0", "frequency of its mode"),
    "azimuthal_number": ("1", "m of its mode"),
    "wave_number": ("1", "j of its mode, q = 2 pi j/8"),
    "residual": ("U", "residual of the steady train"),
}
RATIO, CAPILLARY, VOLUME = "viscosity_ratio", "capillary_number", "reduced_volume"
#: What is varied, by its name in the file: the values, and the tubes.
VARIED = {
    RATIO: ((0.1, 1.0, 5.0, 20.0, 100.0, 1000.0), (8.0, 12.0)),
    CAPILLARY: ((0.4, 0.66, 1.0, 2.0, 4.0, 6.0, 10.0, 20.5), (8.0, 10.0)),
    VOLUME: ((0.4, 0.5, 0.55, 0.6, 0.7, 0.75, 0.8, 0.86), (8.0, 12.0)),
}
#: Headings of the tables, with the paper's statements.
HEADINGS = {
    RATIO: "Viscosity ratio (P20 to P22)",
    CAPILLARY: "Capillary number as the paper counts it (P24, P25)",
    VOLUME: "Reduced volume (P27, P28)",
}
SYMBOLS = {RATIO: r"$\lambda$", CAPILLARY: "Ca", VOLUME: "$v$"}
PACKINGS = (0.2, 0.7)
#: Dense trains in stronger flow than this are long to find, and do not converge: see Fig. 16.
STRONGEST_DENSE = 2.0
#: Degrees that are drawn.
SHOWN = (12, 16, 24, 48)


@dataclass(frozen=True)
class Place:
    """One case: what is varied, its value, and the tube."""

    varied: str
    value: float
    diameter: float
    packing: float

    @property
    def name(self) -> str:
        """As in the file."""
        return f"{self.varied} {self.value:g}, D {self.diameter:g}, packing {self.packing:g}"

    @property
    def train(self) -> Train:
        """The case without a degree."""
        train = Train(diameter=self.diameter, packing=self.packing, cells=CELLS)
        if self.varied == CAPILLARY:
            capillary = paper_units.capillary_number_from_paper(self.value)
            return train.changed(capillary_number=capillary)
        return train.changed(**{self.varied: self.value})


PLACES = [
    Place(varied, value, diameter, packing)
    for varied, (values, diameters) in VARIED.items()
    for diameter in diameters
    for packing in PACKINGS
    for value in values
    if not (varied == CAPILLARY and packing > 0.5 and value > STRONGEST_DENSE)
]


def ladder(
    place: Place, known: dict[int, Base], near: dict[int, Base]
) -> Iterator[tuple[float, ...]]:
    """The `NUMBERS` of a case at each of `LADDER`, NaN where there is no train.

    **Arguments:** `known`: steady trains by degree that serve, to which new ones are added; `near`:
    those of the case before, to go on from.
    """
    lower: Base | None = None
    for degree in LADDER:
        train = place.train.changed(degree=degree)
        try:
            if degree not in known:
                start = near.get(degree, lower) if lower is None else lower
                known[degree] = steady(train, start=start, estimate_error=False)
            lower = known[degree]
            yield leading(replace(lower, train=train))
        except (NotConverged, CaseError):
            yield (math.nan,) * len(NUMBERS)


def leading(base: Base) -> tuple[float, ...]:
    """The fastest growing mode of a train."""
    phases = 2.0 * np.pi * np.arange(CELLS // 2 + 1) / CELLS
    found = []
    for m, blocks in linear_blocks(base, phases, range(MOST_AZIMUTHAL + 1)).items():
        for wave, block in enumerate(blocks):
            value = growing_eigenvalues(block, neutral_space(base, m, wave))[0]
            found.append((value.real, abs(value.imag), float(m), float(wave), base.residual))
    return max(found)


def kept() -> xr.Dataset:
    """What the file holds, over all cases."""
    shape = (len(PLACES), len(LADDER))
    data = xr.Dataset(
        {
            name: (("case", "degree"), np.full(shape, np.nan), {"units": unit, "long_name": long})
            for name, (unit, long) in NUMBERS.items()
        }
        | {"seconds": ("case", np.full(len(PLACES), np.nan), {"units": "s"})},
        coords={
            "case": [place.name for place in PLACES],
            "degree": list(LADDER),
            "varied": ("case", [place.varied for place in PLACES]),
            "value": ("case", [place.value for place in PLACES]),
            "diameter": ("case", [place.diameter for place in PLACES], {"units": "r0"}),
            "packing": ("case", [place.packing for place in PLACES]),
        },
        attrs={
            "title": "largest growth rate over the degree, where the paper and celltrain differ",
            "comment": f"N = {CELLS}, azimuthal numbers 0 to {MOST_AZIMUTHAL}",
        },
    )
    if FILE.is_file():
        with xr.open_dataset(FILE) as file:
            file.load()
        for name in (*NUMBERS, "seconds"):
            for case in np.intersect1d(file["case"], data["case"]):
                data[name].loc[{"case": case}] = file[name].sel(case=case)
    return data


def computed(page: Page) -> xr.Dataset:
    """All cases; what is found is kept after each."""
    data = kept()
    shared: dict[tuple[float, float], dict[int, Base]] = {}
    near: dict[int, Base] = {}
    for place in PLACES:
        if np.isfinite(data["seconds"].sel(case=place.name)):
            continue
        begin = time.perf_counter()
        # The steady train does not depend on the viscosity ratio.
        known: dict[int, Base] = {}
        if place.varied == RATIO:
            known = shared.setdefault((place.diameter, place.packing), {})
        if place.value == VARIED[place.varied][0][0]:
            near = {}
        rows = np.array(list(ladder(place, known, near)))
        near = known
        for name, column in zip(NUMBERS, rows.T, strict=True):
            data[name].loc[{"case": place.name}] = column
        data["seconds"].loc[{"case": place.name}] = time.perf_counter() - begin
        write_dataset(data, FILE)
        page.log(place.name)
    return data


def convergence(data: xr.Dataset, case: str) -> Convergence:
    """alpha of a case over the degrees that have a steady train, by the package's own rule."""
    alpha = data["alpha"].sel(case=case).dropna("degree")
    degrees = tuple(int(each) for each in alpha.degree)
    values = tuple(float(each) for each in alpha)
    return Convergence(degrees[-1] if degrees else 0, degrees, values, LEAST_ERROR * ACCURACY)


def study() -> None:
    page = Page("disputed", "Growth rates over the degree, where the paper and we differ")
    page.text(
        f"""
alpha, the largest growth rate of azimuthal numbers 0 to {MOST_AZIMUTHAL}, N = {CELLS}, at M =
{", ".join(str(each) for each in LADDER)}, in U/r0 (the paper prints ten times as much). Left: what
the last degree leaves open, by the package's own rule. M = 12 is the paper's. The map of Fig. 6 is
on [a page of its own](map.md).
"""
    )
    data = computed(page)
    columns = (*(f"M = {degree}" for degree in LADDER), "left", "m, j at M = 12", "and at last")
    for varied, words in HEADINGS.items():
        page.heading(words)
        chosen = data["case"].values[(data["varied"] == varied).values]
        rows = [_row(data, str(case)) for case in chosen]
        page.table(("D", "packing", words.split(" as ")[0].split(" (")[0].lower(), *columns), rows)
    known = [convergence(data, place.name) for place in PLACES]
    off = [
        abs(each.values[0] / each.values[-1] - 1.0)
        for each in known
        if each.degrees and each.degrees[0] == LADDER[0]
    ]
    page.text(
        f"""
At M = 12 alpha is off by more than a tenth of itself in {sum(each > 0.1 for each in off)} of
{len(off)} cases, by more than half in {sum(each > 0.5 for each in off)}; the paper found 1 % from M
= 12 to 16.
"""
    )
    _figure(page, data)
    page.write()


def _row(data: xr.Dataset, name: str) -> list[str]:
    case, found = data.sel(case=name), convergence(data, name)
    alpha = case["alpha"].values.tolist()
    row = [f"{float(case[each]):g}" for each in ("diameter", "packing", "value")]
    row += ["no train" if math.isnan(each) else f"{each:+.5f}" for each in alpha]
    row.append(f"{found.left:.0e}")
    for degree in (LADDER[0], found.degree or LADDER[-1]):
        at = case.sel(degree=degree)
        m, wave = float(at["azimuthal_number"]), float(at["wave_number"])
        row.append("" if math.isnan(m) else f"{m:.0f}, {wave:.0f}")
    return row


def _figure(page: Page, data: xr.Dataset) -> None:
    """alpha over what is varied, a line for each degree."""
    figure = plain_figure(9.6, 6.4)
    panels = figure.subplots(len(PACKINGS), len(VARIED), sharey="row")
    for row, packing in zip(panels, PACKINGS, strict=True):
        for axes, varied in zip(row, VARIED, strict=True):
            _panel(axes, data, varied, packing)
        row[0].set_ylabel(rf"$\alpha\, r_0/U^*$, $\phi$ = {packing:g}")
    page.figure(figure, "Growth rates in the paper's unit: from M = 12 (light) to 48 (black)")


def _panel(axes: Axes, data: xr.Dataset, varied: str, packing: float) -> None:
    _, diameters = VARIED[varied]
    for diameter, style in zip(diameters, ("o-", "s--"), strict=True):
        here = (data["varied"] == varied) & (data["packing"] == packing)
        chosen = data["alpha"][(here & (data["diameter"] == diameter)).values]
        for degree, shade in zip(SHOWN, np.linspace(0.75, 0.0, len(SHOWN)), strict=True):
            rates = paper_units.rate(chosen.sel(degree=degree).values)
            label = f"D = {diameter:g}, M = {degree}"
            axes.plot(
                chosen["value"], rates, style, color=str(shade), ms=3, linewidth=1.0, label=label
            )
    if varied != VOLUME:
        axes.set_xscale("log")
    axes.set_xlabel(SYMBOLS[varied])
    axes.axhline(0.0, color="0.8", linewidth=0.6, zorder=0)
    axes.legend(fontsize=5.5, frameon=False)
