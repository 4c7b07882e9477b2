"""A complete case: a train of cells in a tube, checked, and dimensionless inside."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Literal

from pydantic import model_validator

from celltrain.parameters.dimension import NUMBER
from celltrain.parameters.errors import CaseError
from celltrain.parameters.fields import described
from celltrain.parameters.resolution import Resolution, Sizes
from celltrain.parameters.routing import DIMENSIONS, KEPT, SECTIONS, SI_LEAVES, flatten, nest
from celltrain.parameters.scales import REFERENCE, Scales
from celltrain.parameters.sections import Cell, Flow, Spacing, Strength, Tube
from celltrain.parameters.strength import put_over
from celltrain.parameters.usual import is_meant, warn_of_unusual

# What may be unusual, by the names under which it is given.
_CHECKED = frozenset(("profile", "cell", "scales"))

Units = Literal["dimensionless", "SI"]


class Train(Spacing):
    """A train of equal cells in single file, periodic along a straight tube.

    Every leaf can be given by its name or in its section::

        Train(diameter=6, packing=0.2, cells=8, degree=16)
        Train(tube=Tube(diameter=6), packing=0.2, cells=8, resolution={"degree": 16})

    Lengths in r0, velocities in U, viscosities in mu; :meth:`from_si` takes SI. Needed are the
    ``diameter`` and the ``packing``; everything else has a default, except the degree: unless it is
    given a train has none until it is computed, and the train of the result has its own. A
    ``capillary_number``, which is no leaf of its own, changes the moduli (see `Strength`).

    Scales and profiles that are no red blood cell's in a capillary are told in a warning
    (`UnusualCase`), unless ``unusual=True`` says that they are meant.

    Raises:
        CaseError: for an unknown name, a leaf given twice, and a value that is not allowed; its
            message names the value and the allowed range.
    """

    tube: Tube
    cell: Cell = Cell()
    flow: Flow = Flow()
    resolution: Resolution = Resolution()
    scales: Scales = Scales()

    if TYPE_CHECKING:  # the leaves arrive by name: more arguments than fields

        def __init__(self, **leaves: object) -> None: ...

    else:

        def __init__(self, **leaves: object) -> None:
            meant = is_meant(leaves)
            super().__init__(**leaves)
            if not meant:
                warn_of_unusual(self.cell, self.scales)

    @model_validator(mode="before")
    @classmethod
    def _route(cls, leaves_or_sections: Mapping[str, object]) -> dict[str, object]:
        given = dict(leaves_or_sections)
        scales = {"scales": given.pop("scales")} if "scales" in given else {}
        leaves = put_over(scales, flatten(given))
        scales = {"scales": leaves.pop("scales")} if "scales" in leaves else {}
        nested = nest(leaves)
        train = nested.pop("train")
        return {**nested, **train, **scales}

    @property
    def period(self) -> float:
        """Axial length of the tube for each cell, 1/packing, r0."""
        return 1 / self.packing

    @property
    def length(self) -> float:
        """Period of the whole train, r0."""
        return self.cells / self.packing

    @property
    def radius(self) -> float:
        """Radius of the tube, r0."""
        return self.tube.diameter / 2

    @property
    def degree(self) -> int:
        """Degree M of the shapes.

        Raises:
            CaseError: if the case has none.
        """
        return self.sizes.degree

    @property
    def sizes(self) -> Sizes:
        """The degree and all sizes of the rules, given or following from it.

        Raises:
            CaseError: if the case has no degree.
        """
        return self.resolution.sizes

    def resolved(self, degree: int) -> "Train":
        """This case with the degree if it has none, otherwise itself.

        Raises:
            CaseError: as when a train is made.
        """
        return self if self.resolution.degree is not None else self.changed(degree=degree)

    def leaf(self, name: str) -> object:
        """The value of a leaf by its name, such as ``"packing"``, or the capillary number.

        Raises:
            CaseError: for an unknown name.
        """
        if name in Strength.model_fields:
            return getattr(self.cell, name)
        leaves = self.leaves()
        if name not in leaves:
            flatten({name: None})  # raises, with the close names, unless it is a section
            raise CaseError(f"{name} is a section, not a leaf")
        return leaves[name]

    def leaves(self, units: Units = "dimensionless") -> dict[str, object]:
        """All leaves by name; in SI together with the three scales, as :meth:`from_si` takes."""
        leaves = flatten(self.sections())
        if units == "dimensionless":
            return leaves
        converted = {
            name: self.scales.si(DIMENSIONS[name], value) for name, value in leaves.items()
        }
        return {**converted, **self.scales.model_dump()}

    def sections(self) -> dict[str, dict[str, object]]:
        """The complete case in the sections of a case file, without the scales."""
        spacing = {name: getattr(self, name) for name in Spacing.model_fields}
        return {
            name: spacing if name == "train" else getattr(self, name).model_dump()
            for name in SECTIONS
        }

    def changed(self, **leaves: object) -> "Train":
        """This case with some leaves (or whole sections) replaced, checked again.

        Of what is unusual (see `Train`) only what is replaced is told.

        Raises:
            CaseError: as when a train is made.
        """
        told = not is_meant(leaves) and not _CHECKED.isdisjoint(leaves)
        scales = leaves.pop("scales", self.scales)
        changed = put_over({**self.leaves(), "scales": scales}, flatten(leaves))
        train = Train(**changed, unusual=True)
        if told:
            warn_of_unusual(train.cell, train.scales)
        return train

    @classmethod
    def from_si(cls, **case: object) -> "Train":
        """A train from SI values under the same leaf names: m, N/m, N m.

        The scales are the leaves ``radius`` (r0, m), ``mean_velocity`` (U, m/s) and
        ``plasma_viscosity`` (mu, Pa s). Packing, viscosity ratio and resolution have no dimension
        (the near cutoff stays in r0). Moduli that are not given are a red blood cell's in SI. A
        ``capillary_number`` sets the mean velocity.

        Raises:
            CaseError: as when a train is made.
        """
        meant = is_meant(case)
        train = cls._from_si_leaves(put_over({}, flatten(case, SI_LEAVES), si=True))
        if not meant:
            warn_of_unusual(train.cell, train.scales)
        return train

    @classmethod
    def _from_si_leaves(cls, leaves: Mapping[str, object]) -> "Train":
        given = {name: leaves[name] for name in Scales.model_fields if name in leaves}
        scales = Scales.of(given)
        # Defaults are the same in SI at all scales.
        defaults = {
            name: field.default * (REFERENCE.unit(DIMENSIONS[name]) / scales.unit(DIMENSIONS[name]))
            for name, field in KEPT.items()
            if isinstance(field.default, float) and DIMENSIONS[name] != NUMBER
        }
        rest = {name: leaves[name] for name in leaves if name not in given}
        converted = {
            **defaults,
            **{name: scales.dimensionless(DIMENSIONS[name], rest[name]) for name in rest},
        }
        try:
            return cls(**converted, scales=scales, unusual=True)
        except CaseError as error:
            pairs = (
                f"{name} = {value!r} in SI is {converted[name]:g} in r0, U, mu"
                for name, value in rest.items()
                if converted[name] is not value and f"{name} = " in str(error)
            )
            raise CaseError("\n".join((str(error), *pairs))) from None

    def to_toml(self) -> str:
        """The complete case as the text of a case file; reading it gives an equal train."""
        lines = [
            "# A case of celltrain: lengths in r0, velocities in U, viscosities in mu.",
            "# Sizes that [resolution] does not have follow from the degree.",
        ]
        for section, values in {**self.sections(), "scales": self.scales.model_dump()}.items():
            fields = SECTIONS.get(section, Scales).model_fields
            lines += ["", f"[{section}]"]
            for name, value in values.items():
                if value is not None:
                    lines.append(f"{name} = {_toml(value)}  # {described(fields[name])}")
        return "\n".join(lines) + "\n"


def _toml(value: object) -> str:
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, tuple):
        return f"[{', '.join(map(_toml, value))}]"
    return repr(value)
