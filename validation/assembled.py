"""Converged data of Figs. 16 and 19 from the growth rates over the degree, as far as these go.

    python validation/assembled.py

writes docs/validation/data/flow-strength.nc and cell-volume.nc from disputed.nc and map.nc. They
hold growth rates, errors and modes at the highest degree only. `celltrain paper fig16` and `fig19`
compute all of it; `python validation/run.py figures --results FOLDER` then takes that.
"""

import numpy as np
import xarray as xr
from disputed import CAPILLARY, FILE, VOLUME, convergence
from page import FOLDER

from celltrain import __version__
from celltrain.paper import FIGURES, paper_study
from celltrain.paper.flow_strength import in_paper_axes
from celltrain.results import write_dataset
from celltrain.study import collect

DATA = FOLDER / "data"
COMMENT = "growth rates at the highest degree of disputed.nc; the other numbers were not computed"
#: The reduced volume of healthy cells, those of the map.
HEALTHY = 0.6444


def assembled(figure: str, varied: str, axis: str) -> xr.Dataset:
    """The data set of a figure's study with what is known of it."""
    with xr.open_dataset(FILE) as found:
        kept = found.load()
    data = collect(paper_study(FIGURES[figure], quick=False), {}).data
    places = in_paper_axes(data) if figure == "fig16" else data
    along = "Ca" if figure == "fig16" else axis
    for case in kept["case"].values[(kept["varied"] == varied).values]:
        at = kept.sel(case=case)
        known = convergence(kept, str(case))
        if not known.degrees:
            continue
        where = {
            "diameter": _place(places["diameter"], float(at["diameter"])),
            "packing": _place(places["packing"], float(at["packing"])),
            axis: _place(places[along], float(at["value"])),
        }
        last = at.sel(degree=known.degree)
        _fill(
            data,
            where,
            spectral_abscissa=known.values[-1],
            error_estimate=known.left,
            taken_degree=known.degree,
            leading_azimuthal_number=float(last["azimuthal_number"]),
            leading_wave_number=float(last["wave_number"]),
            leading_frequency=float(last["frequency"]),
            residual=float(last["residual"]),
            case_seconds=float(at["seconds"]),
        )
    return data.assign_attrs(comment=COMMENT, celltrain_version=__version__)


def with_healthy(data: xr.Dataset) -> xr.Dataset:
    """With the map's trains of healthy cells, and without volumes of which nothing is known."""
    with xr.open_dataset(DATA / "map.nc") as trains:
        trains = trains.load()
    for diameter in data["diameter"].values:
        for packing in data["packing"].values:
            at = trains.sel(diameter=diameter, packing=packing, method="nearest")
            where = {
                "diameter": _place(data["diameter"], diameter),
                "packing": _place(data["packing"], packing),
                "reduced_volume": _place(data["reduced_volume"], HEALTHY),
            }
            names = [name for name in data if data[name].dtype.kind == "f" and name in at]
            _fill(data, where, **{str(name): float(at[name]) for name in names})
    known = data["spectral_abscissa"].notnull().any(("diameter", "packing"))
    return data.isel(reduced_volume=np.flatnonzero(known.values))


def _place(values: xr.DataArray, wanted: float) -> int:
    [place] = np.flatnonzero(np.isclose(values.values, wanted))
    return int(place)


def _fill(data: xr.Dataset, where: dict[str, int], **numbers: float) -> None:
    for name, value in numbers.items():
        data[name][where] = value
    data["status"] = data["status"].astype(object)
    data["status"][where] = "finished"
    data["status"] = data["status"].astype(str)


def main() -> None:
    flow = assembled("fig16", CAPILLARY, "mean_velocity")
    volume = with_healthy(assembled("fig19", VOLUME, "reduced_volume"))
    for data, name in ((flow, "flow-strength"), (volume, "cell-volume")):
        write_dataset(data, DATA / f"{name}.nc")


if __name__ == "__main__":
    main()
