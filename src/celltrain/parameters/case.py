"""Case files: reading TOML, in dimensionless or SI form, with leaves put over it."""

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from celltrain.parameters.errors import CaseError
from celltrain.parameters.routing import LEAVES, SI_LEAVES, flatten
from celltrain.parameters.strength import put_over
from celltrain.parameters.train import Train

UNITS = ("dimensionless", "SI")


def read_case(path: str | Path) -> dict[str, Any]:
    """The content of a TOML case file, not checked yet.

    Raises:
        CaseError: if the file cannot be read or is not TOML.
    """
    try:
        with open(path, "rb") as file:
            return tomllib.load(file)
    except OSError as error:
        raise CaseError(f"case file {str(path)!r} cannot be read: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise CaseError(f"case file {str(path)!r} is not valid TOML: {error}") from None


def merge_case(case: Mapping[str, Any], leaves: Mapping[str, Any]) -> Train:
    """A train from the content of a case file, with leaves by name put over it.

    The key ``units`` ("dimensionless", the default, or "SI") says in what units both are.

    Raises:
        CaseError: as when a train is made.
    """
    both = dict(case)
    changes = dict(leaves)
    units = changes.pop("units", both.pop("units", UNITS[0]))
    both.pop("units", None)
    if units not in UNITS:
        raise CaseError(f"units = {units!r} is not allowed; allowed: {' or '.join(UNITS)}")
    if units == "SI":
        if "scales" in both:
            raise CaseError(
                'section scales is not allowed with units = "SI": give radius in section cell,'
                " mean_velocity and plasma_viscosity in section flow"
            )
        merged = put_over({}, flatten(both, SI_LEAVES), si=True)
        return Train.from_si(**put_over(merged, flatten(changes, SI_LEAVES), si=True))
    scales = {"scales": both.pop("scales")} if "scales" in both else {}
    merged = put_over(scales, flatten(both, LEAVES))
    return Train(**put_over(merged, flatten(changes, LEAVES)))


def load_case(path: str | Path, **leaves: Any) -> Train:
    """The train that a TOML case file describes, with leaves put over it by name.

    Sections are ``[tube]``, ``[cell]``, ``[train]``, ``[flow]`` and ``[resolution]``. With
    ``units = "SI"`` at the top, values (also ``leaves``) are in SI and ``[cell] radius``,
    ``[flow] mean_velocity`` and ``[flow] plasma_viscosity`` may be given (see Train.from_si).

    Raises:
        CaseError: if the file cannot be read or the case is not allowed.
    """
    return merge_case(read_case(path), leaves)
