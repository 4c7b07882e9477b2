"""Routing of leaves: one way from names to sections for Python, case files and command line."""

from collections.abc import Iterable, Mapping
from difflib import get_close_matches

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from celltrain.parameters.dimension import Dimension
from celltrain.parameters.errors import CaseError
from celltrain.parameters.fields import dimension
from celltrain.parameters.resolution import Resolution
from celltrain.parameters.section import Section
from celltrain.parameters.sections import Cell, Flow, Spacing, Strength, Tube

#: The sections of a case, as a case file calls them.
SECTIONS: dict[str, type[Section]] = {
    "tube": Tube,
    "cell": Cell,
    "train": Spacing,
    "flow": Flow,
    "resolution": Resolution,
}

#: Every number that a case keeps, by name.
KEPT: dict[str, FieldInfo] = {
    name: field for section in SECTIONS.values() for name, field in section.model_fields.items()
}

#: Every number that a case takes, by name.
TAKEN: dict[str, FieldInfo] = {**KEPT, **Strength.model_fields}

#: What each number is measured in; making this table fails for a field that does not say it.
DIMENSIONS: dict[str, Dimension] = {name: dimension(field) for name, field in TAKEN.items()}

#: Section -> names of the leaves that it may be given, as in a case file.
LEAVES: dict[str, tuple[str, ...]] = {
    name: tuple(section.model_fields) + (tuple(Strength.model_fields) if name == "flow" else ())
    for name, section in SECTIONS.items()
}

#: The same for a case in SI, where the scales are given with what they belong to.
SI_LEAVES: dict[str, tuple[str, ...]] = {
    **LEAVES,
    "cell": ("radius", *LEAVES["cell"]),
    "flow": ("mean_velocity", "plasma_viscosity", *LEAVES["flow"]),
}

#: The leaves that only a case in SI has.
SCALE_LEAVES = ("radius", "mean_velocity", "plasma_viscosity")


def flatten(
    case: Mapping[str, object], sections: Mapping[str, tuple[str, ...]] = LEAVES
) -> dict[str, object]:
    """The leaves of a case that gives them in sections, by their own names, or as a mixture.

    A section may be a mapping or an object such as ``Tube(diameter=6)``, which gives all its
    leaves. Values are not checked here.

    Raises:
        CaseError: for an unknown name (with the close ones) and for a leaf that is given twice.
    """
    leaves: dict[str, object] = {}
    home = {leaf: section for section, names in sections.items() for leaf in names}
    for name, value in case.items():
        if name in sections:
            given = value.model_dump() if isinstance(value, BaseModel) else value
            if not isinstance(given, Mapping):
                raise CaseError(
                    f"{name} = {value!r} is not allowed: {name} is a section with the leaves"
                    f" {', '.join(sections[name])}"
                )
            for leaf in given:
                if leaf not in sections[name]:
                    raise _unknown(leaf, sections[name], home, f" in section {name}")
        elif name in home:
            given = {name: value}
        else:
            raise _unknown(name, (*sections, *home), home, "")
        for leaf, content in given.items():
            if leaf in leaves:
                raise CaseError(
                    f"{leaf} is given twice, as {leaves[leaf]!r} and as {content!r}:"
                    f" give it once, either in section {home[leaf]} or by its name"
                )
            leaves[leaf] = content
    return leaves


def nest(leaves: Mapping[str, object]) -> dict[str, dict[str, object]]:
    """Leaves sorted into the sections of a case file; every section is there, maybe empty."""
    return {
        section: {name: leaves[name] for name in names if name in leaves}
        for section, names in LEAVES.items()
    }


def _unknown(name: str, allowed: Iterable[str], home: Mapping[str, str], where: str) -> CaseError:
    allowed = tuple(allowed)
    message = f"unknown name {name!r}{where}"
    close = get_close_matches(name, allowed, n=3, cutoff=0.6)
    if name in home:
        message += f" (it belongs to section {home[name]})"
    elif name in SCALE_LEAVES:
        message += (
            ' (a scale: it is part of a case with units = "SI"; to change only how results are'
            " reported in SI, give the section scales)"
        )
    elif close:
        message += f"; did you mean {' or '.join(close)}?"
    return CaseError(f"{message}\nallowed are: {', '.join(allowed)}")
