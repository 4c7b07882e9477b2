"""Case files: reading TOML, in dimensionless or SI form, with leaves put over it."""

import tomllib
from collections.abc import Mapping
from pathlib import Path

from celltrain.parameters.errors import CaseError
from celltrain.parameters.routing import LEAVES, SCALE_LEAVES, SI_LEAVES, flatten
from celltrain.parameters.strength import put_over
from celltrain.parameters.train import Train
from celltrain.parameters.usual import check_scales, check_volume, is_meant

UNITS = ("dimensionless", "SI")


def read_case(path: str | Path) -> dict[str, object]:
    """The content of a TOML case file, not checked yet.

    Names of other files in it are relative to its folder.

    Raises:
        CaseError: if the file cannot be read or is not TOML.
    """
    try:
        # Some editors begin a file with a byte-order mark.
        content = tomllib.loads(Path(path).read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise CaseError(f"case file {str(path)!r} cannot be read: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise CaseError(f"case file {str(path)!r} is not valid TOML: {error}") from None
    return {name: _beside(Path(path), name, each) for name, each in content.items()}


def _beside(path: Path, name: str, value: object) -> object:
    """A value of a case file, with the names of other files relative to that file's folder."""
    if isinstance(value, Mapping):
        return {each: _beside(path, each, inner) for each, inner in value.items()}
    return str(path.parent / value) if name == "profile" and isinstance(value, str) else value


def merge_case(case: Mapping[str, object], leaves: Mapping[str, object]) -> Train:
    """A train from the content of a case file, with leaves by name put over it.

    The key ``units`` ("dimensionless", the default, or "SI") says in what units both are, and
    ``unusual = true`` that they mean what they say: volumes of profiles and scales in SI that are
    no red blood cell's in a capillary are otherwise refused.

    Raises:
        CaseError: as when a train is made, and for what is unusual.
    """
    both = dict(case)
    changes = dict(leaves)
    units = changes.pop("units", both.pop("units", UNITS[0]))
    both.pop("units", None)
    unusual = is_meant(changes if "unusual" in changes else both)
    both.pop("unusual", None)
    if units not in UNITS:
        raise CaseError(f"units = {units!r} is not allowed; allowed: {' or '.join(UNITS)}")
    if units == "SI":
        if "scales" in both:
            raise CaseError(
                'section scales is not allowed with units = "SI": give radius in section cell,'
                " mean_velocity and plasma_viscosity in section flow"
            )
        first, second = flatten(both, SI_LEAVES), flatten(changes, SI_LEAVES)
        if not unusual:
            given = first | second
            check_scales({name: given[name] for name in SCALE_LEAVES if name in given})
        merged = put_over({}, first, si=True)
        train = Train.from_si(**put_over(merged, second, si=True), unusual=True)
    else:
        scales = {"scales": both.pop("scales")} if "scales" in both else {}
        merged = put_over(scales, flatten(both, LEAVES))
        train = Train(**put_over(merged, flatten(changes, LEAVES)), unusual=True)
    if not unusual:
        check_volume(train.cell)
    return train


def load_case(path: str | Path, **leaves: object) -> Train:
    """The train that a TOML case file describes, with leaves put over it by name.

    Sections are ``[tube]``, ``[cell]``, ``[train]``, ``[flow]`` and ``[resolution]``. With
    ``units = "SI"`` at the top, values (also ``leaves``) are in SI and ``[cell] radius``,
    ``[flow] mean_velocity`` and ``[flow] plasma_viscosity`` may be given (see Train.from_si).

    Raises:
        CaseError: if the file cannot be read or the case is not allowed.
    """
    return merge_case(read_case(path), leaves)
