"""What a newcomer's law with a modulus of its own touches: the file of laws and the section.

The package is copied, a law and its registration are written into the one file and the field of its
modulus into the other; all else has to follow.
"""

import ast
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import celltrain
from celltrain.parameters import CaseError, Cell, Train, merge_case
from celltrain.parameters.dimension import BENDING_MODULUS, Dimension
from celltrain.parameters.fields import dimension, plain_type
from celltrain.parameters.routing import SECTIONS, TAKEN
from celltrain.parameters.strength import DRIVEN, MODULI
from celltrain.steady.parameters import MATERIAL, PARAMETERS
from celltrain.study import make_study

SOURCE = Path(celltrain.__file__).parent

LAW = '''
@dataclass(frozen=True)
class Locking:
    """Skalak's law, and a resistance that rises with the fourth power of the strain."""

    shear_modulus: Number
    dilatation_modulus: Number
    locking_modulus: Number

    def energy_density(self, first: Number, second: Number) -> Number:
        """W(I1, I2) per reference area."""
        skalak = Skalak(self.shear_modulus, self.dilatation_modulus)
        return skalak.energy_density(first, second) + self.locking_modulus / 8.0 * first**4


LAWS["locking"] = Locking
'''

FIELD = """\
    locking_modulus: Annotated[Real, SURFACE_MODULUS, Symbol("E_l")] = Field(
        default=REFERENCE.dimensionless(SURFACE_MODULUS, 5e-6),
        ge=0,
        description="locking modulus El of the membrane",
    )
"""

PROGRAM = """
import sys
from contextlib import redirect_stdout
from io import StringIO

import jax.numpy as jnp
import numpy as np

from celltrain import Train, steady
from celltrain.cli import main
from celltrain.continuation import branch
from celltrain.diagnostics import ENERGY_PARTS, FRAME_QUANTITIES, energy_parts
from celltrain.parameters import load_case
from celltrain.pictures.study import LABELS
from celltrain.steady import base_sensitivities
from celltrain.study import make_study
from celltrain.train import train_membrane

NAME = "locking_modulus"
case = {"packing": 0.2, "cells": 1, "degree": 8, "law": "locking"}
train = Train(diameter=6, **case)

# SI, with the default the same in SI at all scales.
slow = Train.from_si(diameter=16.8e-6, mean_velocity=1e-3, **case)
np.testing.assert_allclose(slow.cell.locking_modulus, 5e-6 / 1.2e-6, rtol=1e-14)
np.testing.assert_allclose(slow.leaves("SI")[NAME], 5e-6, rtol=1e-14)
given = Train.from_si(diameter=16.8e-6, locking_modulus=3.45e-6, **case)
np.testing.assert_allclose(given.cell.locking_modulus, 1.0, rtol=1e-14)

# Case files.
with open("case.toml", "w") as file:
    file.write(train.to_toml())
assert load_case("case.toml") == train
assert "locking modulus El of the membrane, mu U" in train.to_toml()

# The strength of the flow.
twice = train.changed(capillary_number=2.0 * train.leaf("capillary_number"))
np.testing.assert_allclose(twice.cell.locking_modulus, 0.5 * train.cell.locking_modulus, rtol=1e-14)

# Derivatives: those of the train itself, and of one function with that by the capillary number.
base = steady(train, tolerance=1e-12, estimate_error=False)
found = base_sensitivities(base)
assert NAME in found
step = 1e-3 * train.cell.locking_modulus
ends = [
    steady(
        train.changed(locking_modulus=train.cell.locking_modulus + change),
        start=base,
        tolerance=1e-12,
        estimate_error=False,
    ).effective_viscosity
    for change in (-step, step)
]
slope = (ends[1] - ends[0]) / (2.0 * step)
assert abs(slope) > 1e-7
np.testing.assert_allclose(found[NAME].effective_viscosity, slope, rtol=1e-3)
relative = {name: train.leaf(name) * each.effective_viscosity for name, each in found.items()
            if name.endswith("modulus") or name == "capillary_number"}
by_flow = relative.pop("capillary_number")
assert len(relative) == 4
np.testing.assert_allclose(by_flow, -sum(relative.values()), rtol=1e-6)
assert NAME not in base_sensitivities(steady(train.changed(law="skalak"), estimate_error=False))

# Branches and studies.
followed = branch(base, NAME, to=1.5 * train.cell.locking_modulus)
assert followed.ending.kind == "reached"
study = make_study({"case": {"diameter": 6, **case}, "axes": {NAME: [1.0, 2.0]}})
assert [each.train.cell.locking_modulus for each in study.cases] == [1.0, 2.0]
study = make_study({"case": {"diameter": 6, **case}, "axes": {"capillary_number": [0.5, 1.0]}})
np.testing.assert_allclose(
    [each.train.cell.locking_modulus * each.train.leaf("capillary_number") for each in study.cases],
    train.cell.locking_modulus * train.leaf("capillary_number"),
    rtol=1e-14,
)
assert LABELS[NAME] == r"$E_l/(\\mu U)$"

# Options and their documentation.
text = StringIO()
sys.argv = ["celltrain", "base", "--help"]
with redirect_stdout(text):
    try:
        main()
    except SystemExit as end:
        assert not end.code
words = " ".join(text.getvalue().replace("│", " ").split())
assert "--locking-modulus FLOAT locking modulus El of the membrane, mu U (in SI N/m;" in words
assert "skalak or neo_hookean or locking" in words

# Energies by what resists.
membrane = train_membrane(train)
shape = jnp.asarray(base.coefficients)
parts = energy_parts(membrane, shape)
assert list(ENERGY_PARTS) == ["shear", "dilatation", "locking", "bending"]
assert parts[2] > 0.0
np.testing.assert_allclose(parts.sum(), membrane.energy(shape), rtol=1e-12)
assert FRAME_QUANTITIES["energy_locking"].symbol == "W_l"
"""


def test_a_modulus_of_ones_own_touches_its_law_and_the_section(tmp_path: Path) -> None:
    copy = tmp_path / "celltrain"
    # With the machine code of its loops, which takes a minute to compile.
    shutil.copytree(SOURCE, copy)
    laws, sections = copy / "laws/constitutive.py", copy / "parameters/sections.py"
    laws.write_text(laws.read_text() + LAW)
    before = "    bending_modulus: Annotated["
    text = sections.read_text()
    assert text.count(before) == 1
    sections.write_text(text.replace(before, FIELD + before))
    subprocess.run(
        [sys.executable, "-c", PROGRAM],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        check=True,
    )


@pytest.mark.parametrize("name", TAKEN)
def test_numbers_of_a_case_say_what_they_are_measured_in(name: str) -> None:
    field = TAKEN[name]
    assert field.description
    assert "U" not in field.description or name in ("capillary_number",)
    if plain_type(field) is float:
        assert any(isinstance(each, Dimension) for each in field.metadata)


def test_a_field_without_its_dimension_is_refused() -> None:
    class Careless(Cell):
        gravity: float = 1.0

    with pytest.raises(TypeError, match="lacks its Dimension"):
        dimension(Careless.model_fields["gravity"])


def test_what_is_derived_of_the_sections() -> None:
    assert MODULI == DRIVEN == ("shear_modulus", "dilatation_modulus", "bending_modulus")
    assert set(MATERIAL) == {*MODULI, "spontaneous_curvature"}
    assert set(PARAMETERS) <= set(TAKEN)
    assert BENDING_MODULUS.unit == "mu U r0^2"
    assert Dimension("s", velocity=-1, length=1).unit == "r0/U"
    assert Dimension("1/m", length=-1).unit == "1/r0"


def test_no_list_names_moduli_by_hand() -> None:
    """Only the laws and the section know that a membrane has a dilatation modulus."""
    homes = {SOURCE / "laws/constitutive.py", SOURCE / "parameters/sections.py"}
    # The paper speaks of one modulus by its name.
    homes |= set((SOURCE / "paper").glob("*.py"))
    for path in set(SOURCE.rglob("*.py")) - homes:
        for node in ast.walk(ast.parse(path.read_text())):
            named = isinstance(node, ast.Constant) and node.value == "dilatation_modulus"
            taken = isinstance(node, ast.Attribute) and node.attr == "dilatation_modulus"
            assert not named, path
            assert not taken, path


def test_the_flows_strength_is_one_number_and_keeps_the_si_values() -> None:
    train = Train(diameter=6, packing=0.2, spontaneous_curvature=0.5, bending="helfrich")
    weak = train.changed(capillary_number=0.1)
    assert weak.leaf("capillary_number") == pytest.approx(0.1, rel=1e-14)
    before, after = train.leaves("SI"), weak.leaves("SI")
    ratio = 0.1 / train.leaf("capillary_number")
    assert after.pop("mean_velocity") == pytest.approx(ratio * before.pop("mean_velocity"))
    for name, value in before.items():
        numeric = isinstance(value, float)
        assert after[name] == (pytest.approx(value, rel=1e-13) if numeric else value)
    # However it is given: by itself, in its section, in SI as the mean velocity.
    assert Train(diameter=6, packing=0.2, capillary_number=0.5).cell == (
        Train(diameter=6, packing=0.2, flow={"capillary_number": 0.5}).cell
    )
    in_si = Train.from_si(diameter=16.8e-6, packing=0.2, capillary_number=0.5)
    assert in_si.scales.mean_velocity == pytest.approx(0.5 * 4.2e-6 / 1.2e-3)
    assert in_si.leaves("SI")["shear_modulus"] == pytest.approx(4.2e-6)
    # The moduli of a case keep their ratio to the shear modulus.
    case = {"diameter": 6, "packing": 0.2, "dilatation_modulus": 10.0}
    stiff = merge_case(case, {"capillary_number": 0.5})
    assert stiff.leaf("capillary_number") == pytest.approx(0.5, rel=1e-14)
    ratio = stiff.cell.dilatation_modulus / stiff.cell.shear_modulus
    assert ratio == pytest.approx(10.0 / train.cell.shear_modulus)
    other = merge_case({"diameter": 6, "packing": 0.2, "capillary_number": 0.5}, {"cells": 2})
    assert other.leaf("capillary_number") == pytest.approx(0.5, rel=1e-14)
    for wrong, words in ((-1.0, "allowed: a number > 0"), ("fast", "capillary_number = 'fast'")):
        with pytest.raises(CaseError, match=words):
            train.changed(capillary_number=wrong)


def test_a_flows_strength_and_what_it_changes_are_not_given_together() -> None:
    both = {"capillary_number": 0.5, "dilatation_modulus": 10.0}
    words = "dilatation_modulus and capillary_number are both given"
    with pytest.raises(CaseError, match=words):
        Train(diameter=6, packing=0.2, **both)
    with pytest.raises(CaseError, match=words):
        Train(diameter=6, packing=0.2).changed(**both)
    axes = {name: [value, 2.0 * value] for name, value in both.items()}
    with pytest.raises(CaseError, match=words):
        make_study({"case": {"diameter": 6, "packing": 0.2}, "axes": axes})
    # In SI the moduli are what they are.
    si = {"diameter": 16.8e-6, "packing": 0.2, "dilatation_modulus": 4e-5, "capillary_number": 0.5}
    train = Train.from_si(**si)
    assert train.leaf("capillary_number") == pytest.approx(0.5, rel=1e-14)
    assert train.leaves("SI")["dilatation_modulus"] == pytest.approx(4e-5, rel=1e-14)
    with pytest.raises(CaseError, match="mean_velocity and capillary_number are both given"):
        Train.from_si(**si, mean_velocity=1e-3)


def test_sections_are_those_of_a_case() -> None:
    train = Train(diameter=6, packing=0.2)
    assert list(train.sections()) == list(SECTIONS)
