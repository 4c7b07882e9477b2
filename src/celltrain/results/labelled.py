"""Results that are a data set with labelled axes themselves."""

from dataclasses import dataclass

import xarray as xr

from celltrain.quantities import Record


@dataclass(frozen=True, eq=False)
class Labelled(Record):
    """Numbers over labelled axes; what they mean are the attributes of the variables."""

    data: xr.Dataset

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Labelled) and self.data.identical(other.data)
