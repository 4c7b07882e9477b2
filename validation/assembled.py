"""Converged data of Fig. 16 from the growth rates over the degree, as far as these go.

    python validation/assembled.py

writes docs/validation/data/flow-strength.nc from disputed.nc. It holds growth rates, errors and
modes at the highest degree only. `celltrain paper fig16` computes all of it; `python
validation/run.py figures --results FOLDER` then takes that.
"""

import numpy as np
import xarray as xr
from disputed import CAPILLARY, FILE, convergence
from page import FOLDER

from celltrain import __version__
from celltrain.paper import FIGURES, paper_study
from celltrain.paper.flow_strength import in_paper_axes
from celltrain.results import write_dataset
from celltrain.study import collect

DATA = FOLDER / "data"
COMMENT = "growth rates at the highest degree of disputed.nc; the other numbers were not computed"


def assembled() -> xr.Dataset:
    """The data set of the figure's study with what is known of it."""
    with xr.open_dataset(FILE) as found:
        kept = found.load()
    data = collect(paper_study(FIGURES["fig16"], quick=False), {}).data
    places = in_paper_axes(data)
    for case in kept["case"].values[(kept["varied"] == CAPILLARY).values]:
        at = kept.sel(case=case)
        known = convergence(kept, str(case))
        if not known.degrees:
            continue
        where = {
            "diameter": _place(places["diameter"], float(at["diameter"])),
            "packing": _place(places["packing"], float(at["packing"])),
            "mean_velocity": _place(places["Ca"], float(at["value"])),
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
    write_dataset(assembled(), DATA / "flow-strength.nc")


if __name__ == "__main__":
    main()
