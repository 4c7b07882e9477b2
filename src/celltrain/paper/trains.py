"""The paper's trains at either resolution, and the data of single trains beside each other."""

from collections.abc import Sequence

import xarray as xr

from celltrain.parameters import Train
from celltrain.stability import Stability, stability
from celltrain.stability.convergence import NUMBERS
from celltrain.steady import Base

#: The degree at which the paper computed.
PAPER_DEGREE = 12
#: Its number of cells, and the corners of its maps: diameter and packing.
CELLS = 8
CORNERS = ((6.0, 0.2), (6.0, 0.7), (10.0, 0.2), (10.0, 0.7))


def analysed(
    degree: int | None,
    *,
    numbers: Sequence[int] | None = NUMBERS,
    start: Base | None = None,
    cells: int = CELLS,
    **case: object,
) -> Stability:
    """The linear dynamics of a train; without a degree it rises until alpha is known.

    **Raises:** `CaseError` for what is not allowed, `NotConverged` if there is no steady train.
    """
    train = Train(cells=cells, degree=degree, **case)
    return stability(train, start=start, azimuthal_numbers=numbers)


def dataset(
    variables: dict[str, tuple[object, ...]], coordinates: dict[str, object], title: str
) -> xr.Dataset:
    """Data with a title; variables are (dimensions, values, unit, words)."""
    return xr.Dataset(
        {
            name: (dims, values, {"units": unit, "long_name": words})
            for name, (dims, values, unit, words) in variables.items()
        },
        coords=coordinates,
        attrs={"title": title},
    )
