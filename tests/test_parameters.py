"""Cases: routing of leaves, defaults, ranges with their messages, SI, and TOML."""

import math
import pickle
from dataclasses import asdict

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from celltrain.parameters import (
    CaseError,
    Cell,
    Flow,
    Resolution,
    Scales,
    Sizes,
    Train,
    Tube,
    load_case,
    merge_case,
    paper_units,
)

NOMINAL = {"diameter": 6, "packing": 0.2, "cells": 8}


def test_leaves_and_sections_say_the_same():
    by_name = Train(**NOMINAL, degree=16, shear_modulus=2)
    by_section = Train(
        tube=Tube(diameter=6),
        cell=Cell(shear_modulus=2.0),
        flow=Flow(),
        resolution={"degree": 16},
        train={"packing": 0.2, "cells": 8},
    )
    assert by_name == by_section
    assert hash(by_name) == hash(by_section)
    assert by_name.period == 5
    assert by_name.length == 40
    assert by_name.radius == 3


def test_defaults_are_the_red_blood_cell_in_the_reference_scales():
    train = Train(**NOMINAL)
    assert train.cell.shear_modulus == pytest.approx(1.2174, rel=1e-4)
    assert train.cell.dilatation_modulus == pytest.approx(19.62, rel=1e-3)
    assert train.cell.bending_modulus == pytest.approx(6.655e-3, rel=1e-4)
    assert train.cell.capillary_number == pytest.approx(0.82, abs=0.005)
    assert train.resolution.model_dump() == {
        "degree": None,
        "grading": 0.0,
        "energy_order": None,
        "source_order": None,
        "target_order": None,
        "polar_radial": None,
        "polar_azimuthal": None,
        "near_cutoff": 2.5,
        "tolerance": 1e-6,
    }


@pytest.mark.parametrize(
    ("leaves", "parts"),
    [
        ({"diameter": -1}, ["diameter = -1", "> 0 and <= 100"]),
        ({"diameter": "6"}, ["diameter = '6'", "a number > 0"]),
        ({"diameter": True}, ["diameter = True"]),
        ({"diameter": math.nan}, ["diameter = nan", "> 0"]),
        ({"packing": 0}, ["packing = 0", "> 0"]),
        ({"cells": 0}, ["cells = 0", "a whole number 1 to 10000"]),
        ({"cells": 2.5}, ["cells = 2.5", "a whole number 1 to 10000"]),
        ({"shear_modulus": -1.0}, ["shear_modulus = -1.0", "> 0"]),
        ({"dilatation_modulus": 0}, ["dilatation_modulus = 0", "> 0"]),
        ({"bending_modulus": -1e-3}, ["bending_modulus = -0.001", ">= 0"]),
        ({"viscosity_ratio": 0}, ["viscosity_ratio = 0", "> 0"]),
        ({"law": "hooke"}, ["law = 'hooke'", "skalak or neo_hookean"]),
        ({"reference": "cube"}, ["reference = 'cube'", "biconcave or sphere"]),
        ({"degree": 4}, ["degree = 4", "6 to 64", "resting cell"]),
        ({"degree": "12"}, ["degree = '12'", "6 to 64"]),
        ({"degree": 12, "source_order": 8}, ["source_order = 8", ">= 12"]),
        ({"degree": 12, "target_order": 11}, ["target_order = 11", ">= 12"]),
        ({"degree": 12, "energy_order": 11}, ["energy_order = 11", ">= 12"]),
        ({"polar_azimuthal": 37}, ["polar_azimuthal = 37", "multiple of 2"]),
        ({"tolerance": 1e-13}, ["tolerance = 1e-13", "1e-12 to 0.001"]),
        ({"near_cutoff": 0}, ["near_cutoff = 0", "> 0"]),
        ({"diamter": 6}, ["'diamter'", "did you mean diameter?", "viscosity_ratio"]),
        ({"mean_velocity": 1e-3}, ["'mean_velocity'", 'units = "SI"']),
        ({"tube": {"diameter": 5}}, ["diameter is given twice", "5", "6"]),
        ({"cell": Cell(), "law": "skalak"}, ["law is given twice"]),
        ({"cell": {"diameter": 5}}, ["section cell", "belongs to section tube"]),
        ({"cell": 3}, ["cell = 3", "shear_modulus"]),
        ({"scales": {"radius": -1}}, ["radius = -1", "> 0"]),
        ({"cells": 0, "degree": 4}, ["cells = 0", "degree = 4"]),
    ],
)
def test_messages_name_the_value_and_what_is_allowed(leaves, parts):
    with pytest.raises(CaseError) as caught:
        Train(**(NOMINAL | leaves))
    message = str(caught.value)
    assert all(part in message for part in parts), message
    assert "validation error" not in message
    assert "pydantic" not in message


def test_what_is_missing_is_named():
    with pytest.raises(CaseError, match="diameter is missing") as caught:
        Train()
    assert "packing is missing" in str(caught.value)


def test_sections_alone_have_the_same_messages():
    with pytest.raises(CaseError, match="diameter = -1 is not allowed"):
        Tube(diameter=-1)
    with pytest.raises(CaseError, match="unknown name 'size'"):
        Tube(diameter=6, size=3)


def test_numpy_numbers_are_numbers():
    train = Train(diameter=np.float64(6), packing=np.float32(0.5), cells=np.int64(4))
    assert (train.packing, train.cells) == (0.5, 4)
    assert type(train.packing) is float
    assert type(train.cells) is int


def test_a_train_is_frozen():
    train = Train(**NOMINAL)
    with pytest.raises(ValueError, match="frozen"):
        train.packing = 0.5
    assert pickle.loads(pickle.dumps(train)) == train
    assert Train(**train.model_dump()) == train
    assert Train(**train.sections()) == train


def test_leaf_by_name():
    train = Train(**NOMINAL)
    assert train.leaf("packing") == 0.2
    assert train.leaf("law") == "skalak"
    assert set(train.leaves()) >= {"diameter", "degree", "viscosity_ratio", "cells"}
    with pytest.raises(CaseError, match="did you mean packing"):
        train.leaf("packin")
    with pytest.raises(CaseError, match="section"):
        train.leaf("tube")


def test_every_leaf_can_be_changed():
    train = Train(**NOMINAL, **asdict(Resolution(degree=12).sizes))
    other = {
        "law": "neo_hookean",
        "bending": "helfrich",
        "reference": "sphere",
        "reduced_volume": 0.8,
    }
    # These belong to other values of another leaf.
    owned = {"spontaneous_curvature", "aspect_ratio", "profile"}
    for name, value in train.leaves().items():
        if name in owned:
            continue
        new = other.get(name) or value + (2 if isinstance(value, int) else 1e-5)
        changed = train.changed(**{name: new})
        assert changed.leaf(name) == new
        assert changed.changed(**{name: value}) == train


def test_sizes_follow_the_degree_unless_given():
    train = Train(**NOMINAL, degree=12)
    assert train.degree == 12
    assert train.sizes == Sizes(
        degree=12,
        energy_order=36,
        source_order=30,
        target_order=14,
        polar_radial=28,
        polar_azimuthal=42,
    )
    given = train.changed(source_order=28)
    finer = given.changed(degree=17)
    assert finer.resolution == Resolution(degree=17, source_order=28)
    assert finer.sizes == Sizes(17, 51, 28, 19, 40, 60)
    with pytest.raises(CaseError, match="source_order = 28"):
        given.changed(degree=32)


@pytest.mark.parametrize("degree", range(6, 49))
def test_usual_sizes_are_allowed_at_any_degree(degree):
    sizes = Resolution(degree=degree).sizes
    assert Resolution(**asdict(sizes)).sizes == sizes


def test_a_train_need_not_have_a_degree():
    train = Train(**NOMINAL, source_order=20)
    assert train.leaf("degree") is None
    for ask in (lambda: train.degree, lambda: train.sizes, lambda: Resolution().sizes):
        with pytest.raises(CaseError, match=r"degree is not given.* \(6 to 64\)"):
            ask()
    assert train.resolved(12) == train.changed(degree=12)
    assert train.resolved(12).resolved(16).degree == 12
    assert train.resolved(12).changed(degree=None) == train
    # A grid that is given must hold the shape as soon as there is a degree.
    with pytest.raises(CaseError, match="source_order = 20 is not allowed"):
        train.resolved(24)
    assert train != train.resolved(12)
    assert Train(**train.model_dump()) == Train(**train.sections()) == train


def test_a_train_in_si_need_not_have_a_degree():
    train = Train.from_si(diameter=16.8e-6, packing=0.2)
    assert train.resolution == Resolution()
    assert Train.from_si(**train.leaves("SI")).resolution == Resolution()
    assert Train.from_si(diameter=16.8e-6, packing=0.2, degree=16).degree == 16


def test_a_change_keeps_the_scales_and_is_checked():
    train = Train(**NOMINAL, scales=Scales(radius=3e-6))
    assert train.changed(packing=0.5).scales.radius == 3e-6
    assert train.changed(tube=Tube(diameter=7)).tube.diameter == 7
    with pytest.raises(CaseError, match="packing = -2"):
        train.changed(packing=-2)
    with pytest.raises(CaseError, match="unknown name 'pack'"):
        train.changed(pack=2)


def test_si_defaults_are_the_dimensionless_ones():
    train = Train.from_si(diameter=6 * 2.8e-6, packing=0.2)
    assert train.cell == Cell()
    assert train.scales == Scales()
    assert train.tube.diameter == pytest.approx(6, rel=1e-15)


def test_si_is_converted_with_the_scales_given():
    train = Train.from_si(
        diameter=12e-6,
        packing=0.2,
        radius=3e-6,
        mean_velocity=1e-3,
        plasma_viscosity=1e-3,
        shear_modulus=4e-6,
        bending_modulus=1.8e-19,
    )
    assert train.tube.diameter == pytest.approx(4)
    assert train.cell.shear_modulus == pytest.approx(4)
    assert train.cell.dilatation_modulus == pytest.approx(67.7)
    assert train.cell.bending_modulus == pytest.approx(1.8e-19 / (1e-6 * 9e-12))
    assert train.scales.time == pytest.approx(3e-3)
    assert train.scales.pressure == pytest.approx(1 / 3)
    back = Train.from_si(**train.leaves("SI"))
    for name, value in train.leaves().items():
        assert back.leaf(name) == (
            value if value is None or isinstance(value, str) else pytest.approx(value, rel=1e-14)
        )


@pytest.mark.parametrize(
    ("leaves", "parts"),
    [
        ({"diameter": -7e-6}, ["diameter = -2.5", "> 0", "diameter = -7e-06 in SI"]),
        ({"diameter": "wide"}, ["diameter = 'wide'"]),
        ({"diameter": 6}, ["in SI", "<= 100"]),
        ({"mean_velocity": 0}, ["mean_velocity = 0", "> 0"]),
        ({"radius": "big"}, ["radius = 'big'"]),
        ({"shear_modulus": -4e-6}, ["shear_modulus = -4e-06 in SI", "> 0"]),
        ({"viscosity": 1}, ["unknown name 'viscosity'", "plasma_viscosity"]),
    ],
)
def test_messages_in_si(leaves, parts):
    with pytest.raises(CaseError) as caught:
        Train.from_si(**({"diameter": 16e-6, "packing": 0.2} | leaves))
    assert all(part in str(caught.value) for part in parts), caught.value


def test_paper_units_and_back():
    assert paper_units.rate(0.01165) == pytest.approx(0.1165)
    assert paper_units.time(700.0) == pytest.approx(70)
    assert paper_units.capillary_number(Cell().capillary_number) == pytest.approx(0.66, abs=0.005)
    values = np.array([0.3, 5.0])
    for there, back in (
        (paper_units.rate, paper_units.rate_from_paper),
        (paper_units.time, paper_units.time_from_paper),
        (paper_units.capillary_number, paper_units.capillary_number_from_paper),
    ):
        np.testing.assert_allclose(back(there(values)), values, rtol=1e-15)


@given(
    diameter=st.floats(2.78, 100),
    packing=st.floats(1e-3, 1.0),
    cells=st.integers(1, 100),
    degree=st.none() | st.integers(6, 64),
    shear_modulus=st.floats(1e-6, 1e6),
    viscosity_ratio=st.floats(1e-3, 1e3),
    tolerance=st.floats(1e-12, 1e-3),
    law=st.sampled_from(["skalak", "neo_hookean"]),
)
def test_toml_round_trip_is_exact(tmp_path_factory, **leaves):
    train = Train(**leaves, scales=Scales(radius=1 / 3e5))
    path = tmp_path_factory.mktemp("case") / "case.toml"
    path.write_text(train.to_toml())
    assert load_case(path) == train
    assert ("\ndegree = " in train.to_toml()) == (leaves["degree"] is not None)


def test_case_file_with_options_over_it(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(
        "[tube]\ndiameter = 6\n[train]\npacking = 0.2\n[resolution]\ndegree = 12\n"
        "source_order = 25\n"
    )
    assert load_case(path, packing=0.5).packing == 0.5
    finer = load_case(path, degree=16).sizes
    assert (finer.energy_order, finer.source_order) == (48, 25)


def test_case_file_in_si(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(
        'units = "SI"\n[tube]\ndiameter = 16.8e-6\n[cell]\nradius = 2.8e-6\n'
        "shear_modulus = 4.2e-6\n[train]\npacking = 0.2\n"
        "[flow]\nmean_velocity = 2.875e-3\nplasma_viscosity = 1.2e-3\n"
    )
    train = load_case(path)
    assert train.cell == Cell()
    assert load_case(path, mean_velocity=1e-3).cell.shear_modulus == pytest.approx(3.5)
    path.write_text(train.to_toml())
    assert load_case(path) == train


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("[tube]\ndiamter = 6", ["'diamter'", "section tube", "did you mean diameter"]),
        ("[tub]\ndiameter = 6", ["'tub'", "did you mean tube"]),
        ("[tube]\ndiameter = ", ["not valid TOML"]),
        ('units = "CGS"\n[tube]\ndiameter = 6', ["units = 'CGS'", "dimensionless or SI"]),
        ('units = "SI"\n[scales]\nradius = 1', ["section scales", "section cell"]),
        ("tube = 6", ["tube = 6", "section"]),
    ],
)
def test_messages_for_case_files(tmp_path, text, parts):
    path = tmp_path / "case.toml"
    path.write_text(text)
    with pytest.raises(CaseError) as caught:
        load_case(path)
    assert all(part in str(caught.value) for part in parts), caught.value


def test_case_file_that_cannot_be_read(tmp_path):
    with pytest.raises(CaseError, match="cannot be read"):
        load_case(tmp_path / "missing.toml")
    with pytest.raises(CaseError, match="cannot be read"):
        load_case(tmp_path)
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(CaseError, match="not valid TOML"):
        load_case(tmp_path / "binary.toml")


def test_units_of_the_options_win_over_those_of_the_file():
    case = {"units": "SI", "tube": {"diameter": 16.8e-6}, "train": {"packing": 0.2}}
    assert merge_case(case, {}).tube.diameter == pytest.approx(6)
    assert merge_case(case, {"units": "dimensionless"}).tube.diameter == 16.8e-6
