"""Studies of distributions, and results of them that are made up."""

import math

from celltrain.study import (
    CaseRecord,
    Sampled,
    SampledStudy,
)
from celltrain.study.sampling.draws import COLUMNS, DrawRecord

CELLS = {
    "case": {"diameter": 6, "packing": 0.2, "degree": 6},
    "distributions": {
        "shear_modulus": {"lognormal": {"relative_deviation": 0.3}},
        "viscosity_ratio": {"uniform": {"from": 1, "to": 5}},
    },
    "sample": {"points": 16},
}
SI = {
    "units": "SI",
    "case": {"diameter": 16.8e-6, "packing": 0.2, "degree": 6},
    "distributions": {
        "radius": {"normal": {"mean": 2.8e-6, "relative_deviation": 0.04}},
        "shear_modulus": {"lognormal": {"relative_deviation": 0.3}},
    },
    "sample": {"points": 16},
}


def made_up(study: SampledStudy, failing: tuple[tuple[int, int], ...] = ()) -> Sampled:
    """Records that nobody computed: the growth rate follows the shear modulus."""
    central = CaseRecord(
        address="0" * 24,
        version="0",
        status="finished",
        reason="",
        origin="",
        case={},
        computed={},
        values={**dict.fromkeys(COLUMNS, 1.0), "taken_degree": 6.0, "error_estimate": 1e-5},
    )
    records: dict[tuple[int, ...], DrawRecord] = {}
    for draw in study.draws:
        if draw.index in failing:
            records[draw.index] = DrawRecord("failed", "NotConverged: not\ntoday", {})
            continue
        values = dict.fromkeys(COLUMNS, 2.0)
        values["spectral_abscissa"] = draw.train.cell.shear_modulus - 1.0
        values["cell_velocity"] = draw.train.flow.viscosity_ratio + draw.train.cell.shear_modulus
        values["error_estimate"] = 1e-4 if draw.checked else math.nan
        records[draw.index] = DrawRecord("finished", "", values)
    return Sampled(central, records)
