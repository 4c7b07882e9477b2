"""The trains of the page on capillaries: computed once, kept as small files.

From nothing that takes ten minutes on two cores.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from page import FOLDER, Page

from celltrain import Base, CaseError, Train, steady
from celltrain.diagnostics import discharge_haematocrit, lubricated, tube_haematocrit
from celltrain.results import write_dataset
from celltrain.stability.linearise import linear_blocks
from celltrain.stability.neutral import neutral_space
from celltrain.stability.spectrum import growing_eigenvalues
from celltrain.steady import NotConverged

CELL_RADIUS = 2.8e-6
#: Tubes (um) and discharge haematocrits that are compared with measurements, and the speed, m/s.
DIAMETERS = (4.0, 5.0, 6.0, 7.0, 8.0, 10.0)
HAEMATOCRITS = (0.15, 0.3, 0.45, 0.5)
SPEED = 1e-3
#: Tubes (r0), and pairs of a speed (m/s) and a packing, of the map of growth rates.
MAP_DIAMETERS = (1.6, 2.0, 2.5, 3.0, 3.5)
MAP_SPEEDS = (1e-4, 1e-3, 1e-2)
MAP_PACKINGS = (0.1, 0.25)
#: With the grading of the cells in tubes below `NARROW`, and the narrowest tube.
MAP_CASES = (
    (1e-3, 0.25, 1.0, 1.6),
    (1e-4, 0.25, 1.0, 1.6),
    (1e-2, 0.25, 1.0, 2.5),
    (1e-3, 0.1, 0.0, 1.6),
)
#: Azimuthal numbers, and those of the narrow tubes alone, whose cells fold in many lobes.
NUMBERS = tuple(range(15))
LOBED = tuple(range(11, 15))
#: Disturbances of higher numbers die out from cell to cell: two phases are enough.
LOW_NUMBERS = (0, 1)
CELLS = 8
#: Tubes (r0) in which the speed changes at one packing, and the speeds, m/s.
FILM_DIAMETERS = (2.0,)
FILM_PACKING = 0.1
FILM_SPEEDS = (2e-4, 5e-4, 1e-3, 2e-3)
#: Below this diameter (r0) trains are computed at the higher pair of degrees.
NARROW = 2.4
DEGREES, NARROW_DEGREES = (20, 24), (24, 32)
#: How exactly a haematocrit is met.
MET = 2e-3

DATA = FOLDER / "data"
MEASURED, MAP, FILMS = (
    DATA / f"capillaries-{name}.nc" for name in ("measured", "stability", "films")
)

RATES = {"rate": "U/r0", "frequency": "U/r0", "wave": "1", "coarse_rate": "U/r0"}
NUMBERS_KEPT = {
    "packing": "1",
    "tube_haematocrit": "1",
    "discharge_haematocrit": "1",
    "cell_velocity": "U",
    "viscosity": "mu",
    "film": "r0",
    "gap": "r0",
    "length": "r0",
    "residual": "U",
    "truncation_error": "U",
    "degree": "1",
    "coarse_velocity": "U",
    "coarse_viscosity": "mu",
    "coarse_film": "r0",
    "lubricated_velocity": "U",
    "lubricated_viscosity": "mu",
}


@dataclass(frozen=True)
class Pair:
    """One train at two degrees."""

    coarse: Base
    fine: Base

    def numbers(self) -> dict[str, float]:
        """What is kept of it."""
        base, coarse = self.fine, self.coarse
        velocity, viscosity = lubricated(base)
        return {
            "packing": base.train.packing,
            "tube_haematocrit": tube_haematocrit(base),
            "discharge_haematocrit": discharge_haematocrit(base),
            "cell_velocity": base.cell_velocity,
            "viscosity": base.effective_viscosity,
            "film": base.train.radius - base.largest_radius,
            "gap": base.gap,
            "length": base.train.period - base.gap,
            "residual": base.residual,
            "truncation_error": base.truncation_error,
            "degree": base.train.degree,
            "coarse_velocity": coarse.cell_velocity,
            "coarse_viscosity": coarse.effective_viscosity,
            "coarse_film": coarse.train.radius - coarse.largest_radius,
            "lubricated_velocity": velocity,
            "lubricated_viscosity": viscosity,
        }


def case(diameter: float, packing: float, speed: float, grading: float = 0.0) -> Train:
    """A train in a tube of a diameter in r0, a speed in m/s."""
    return Train.from_si(
        radius=CELL_RADIUS,
        diameter=diameter * CELL_RADIUS,
        mean_velocity=speed,
        packing=packing,
        cells=CELLS,
        grading=grading if diameter < NARROW else 0.0,
    )


def degrees(diameter: float) -> tuple[int, int]:
    """The degree at which a train is computed, and the one below that tells its error."""
    low, high = NARROW_DEGREES if diameter < NARROW else DEGREES
    return low, high


def pair(train: Train, start: Base | None) -> Pair:
    """The train at both degrees, from another one.

    **Raises:** `NotConverged` or `CaseError` if there is none.
    """
    low, high = degrees(train.tube.diameter)
    fine = steady(train.changed(degree=high), start=start, estimate_error=False)
    return Pair(steady(train.changed(degree=low), start=fine, estimate_error=False), fine)


def measured(page: Page) -> xr.Dataset:
    """Trains at the diameters and discharge haematocrits of the comparison."""
    kept = _begun(MEASURED, {"diameter": DIAMETERS, "haematocrit": HAEMATOCRITS})
    kept["diameter"].attrs["units"] = "um"
    # The first from wide to narrow tubes, the denser ones from the one before in the same tube.
    last: dict[float, Base] = {}
    for share in HAEMATOCRITS:
        near: Base | None = None
        for diameter in sorted(DIAMETERS, reverse=share == HAEMATOCRITS[0]):
            place = {"diameter": diameter, "haematocrit": share}
            if _known(kept, place):
                continue
            size = diameter * 1e-6 / CELL_RADIUS
            try:
                found = _at_share(size, share, last.get(diameter, near))
            except (NotConverged, CaseError) as error:
                page.log(f"{diameter:g} um, {share:g}: {error}")
                continue
            near = last[diameter] = found.fine
            _keep(kept, MEASURED, found.numbers(), place)
            page.log(f"{diameter:g} um, {share:g}: {found.fine.effective_viscosity:.4f}")
    return _ended(kept, MEASURED, len(DIAMETERS) * len(HAEMATOCRITS))


def _at_share(diameter: float, share: float, start: Base | None) -> Pair:
    """The train of a discharge haematocrit: its packing follows from the velocity it has."""
    _, high = degrees(diameter)
    # V = 4 pi/3 r0^3.
    packing = 0.75 * share * (diameter / 2.0) ** 2 / (start.cell_velocity if start else 1.5)
    while True:
        train = case(diameter, packing, SPEED)
        start = steady(train.changed(degree=high), start=start, estimate_error=False)
        wrong = discharge_haematocrit(start) / share
        if abs(wrong - 1.0) < MET:
            return pair(train, start)
        packing /= wrong


def stability_map(page: Page) -> xr.Dataset:
    """Trains, and the fastest disturbance of each azimuthal number, at two degrees."""
    axes = {"diameter": MAP_DIAMETERS, "packing_given": MAP_PACKINGS, "speed": MAP_SPEEDS}
    kept = _begun(MAP, axes)
    if "m" not in kept.coords:
        shape = (*(len(each) for each in axes.values()), len(NUMBERS))
        kept = kept.assign_coords(m=("m", list(NUMBERS)))
        for name, unit in RATES.items():
            kept[name] = ((*axes, "m"), np.full(shape, np.nan), {"units": unit})
    for speed, packing, diameter, grading, start in _walk():
        place = {"diameter": diameter, "packing_given": packing, "speed": speed}
        if _known(kept, place):
            continue
        try:
            found = pair(case(diameter, packing, speed, grading), start.get("base"))
        except (NotConverged, CaseError) as error:
            page.log(f"{speed:g} m/s, packing {packing:g}, D = {diameter:g}: {error}")
            continue
        start["base"] = found.fine
        numbers = tuple(m for m in NUMBERS if m not in LOBED or diameter < NARROW)
        fine, coarse = _leading(found.fine, numbers), _leading(found.coarse, numbers)
        for m in numbers:
            kept["wave"].loc[{**place, "m": m}], value = fine[m][0], fine[m][1]
            kept["rate"].loc[{**place, "m": m}] = value.real
            kept["frequency"].loc[{**place, "m": m}] = value.imag
            kept["coarse_rate"].loc[{**place, "m": m}] = coarse[m][1].real
        _keep(kept, MAP, found.numbers(), place)
        rates = " ".join(f"{fine[m][1].real:+.4f}" for m in numbers)
        page.log(f"{speed:g} m/s, packing {packing:g}, D = {diameter:g}: {rates}")
    return _ended(kept, MAP, len(list(_walk())))


def _walk() -> Iterator[tuple[float, float, float, float, dict[str, Base]]]:
    """Speeds, packings, diameters, wide to narrow, gradings, and where to keep the last train."""
    for speed, packing, grading, narrowest in MAP_CASES:
        last: dict[str, Base] = {}
        for diameter in sorted(MAP_DIAMETERS, reverse=True):
            if diameter < narrowest:
                break
            yield speed, packing, diameter, grading, last


def _leading(base: Base, numbers: tuple[int, ...]) -> dict[int, tuple[int, complex]]:
    """For each azimuthal number the wave of the fastest disturbance, and its eigenvalue."""
    found = {}
    high = tuple(m for m in numbers if m not in LOW_NUMBERS)
    for group, waves in ((LOW_NUMBERS, range(CELLS // 2 + 1)), (high, (0, CELLS // 2))):
        phases = [2.0 * np.pi * j / CELLS for j in waves]
        for m, blocks in linear_blocks(base, phases, group).items():
            values = [
                growing_eigenvalues(block, neutral_space(base, m, 0 if q == 0.0 else 1))[0]
                for q, block in zip(phases, blocks, strict=True)
            ]
            place = int(np.argmax(np.real(values)))
            found[m] = waves[place], complex(values[place])
    return found


def films(page: Page) -> xr.Dataset:
    """Trains in tight tubes over the speed of the flow, from the middle one to both ends."""
    kept = _begun(FILMS, {"diameter": FILM_DIAMETERS, "speed": FILM_SPEEDS})
    middle = FILM_SPEEDS.index(SPEED)
    for diameter in FILM_DIAMETERS:
        begin: Base | None = None
        for speeds in (FILM_SPEEDS[middle:], FILM_SPEEDS[middle::-1]):
            last = begin
            for speed in speeds:
                if _known(kept, {"diameter": diameter, "speed": speed}):
                    continue
                try:
                    found = pair(case(diameter, FILM_PACKING, speed), last)
                except (NotConverged, CaseError) as error:
                    page.log(f"D = {diameter:g}, {speed:g} m/s: {error}")
                    break
                last = found.fine
                if speed == SPEED:
                    begin = last
                _keep(kept, FILMS, found.numbers(), {"diameter": diameter, "speed": speed})
                film = diameter / 2.0 - found.fine.largest_radius
                page.log(f"D = {diameter:g}, {speed:g} m/s: film {film:.4f}")
    return _ended(kept, FILMS, len(FILM_DIAMETERS) * len(FILM_SPEEDS))


def _part(path: Path) -> Path:
    """What is kept of a study under way, which goes on from there when it is run again."""
    return path.with_suffix(".part.nc")


def _begun(path: Path, axes: dict[str, tuple[float, ...]]) -> xr.Dataset:
    if _part(path).is_file():
        return xr.load_dataset(_part(path))
    shape = tuple(len(each) for each in axes.values())
    return xr.Dataset(
        {
            name: (tuple(axes), np.full(shape, np.nan), {"units": unit})
            for name, unit in NUMBERS_KEPT.items()
        },
        coords={name: list(values) for name, values in axes.items()},
    )


def _known(kept: xr.Dataset, place: dict[str, float]) -> bool:
    return bool(np.isfinite(kept["cell_velocity"].sel(place)))


def _keep(kept: xr.Dataset, path: Path, numbers: dict[str, float], place: dict[str, float]) -> None:
    for name, value in numbers.items():
        kept[name].loc[place] = value
    write_dataset(kept, _part(path))


def _ended(kept: xr.Dataset, path: Path, wanted: int) -> xr.Dataset:
    """The same, if as many trains are there as are wanted.

    **Raises:** `RuntimeError` if something is.
    """
    missing = wanted - int(np.isfinite(kept["cell_velocity"]).sum())
    if missing:
        raise RuntimeError(f"{path.stem}: {missing} trains are missing")
    _part(path).unlink()
    return kept
