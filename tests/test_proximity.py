"""What all searches for closeness share: boxes, and nearest points on the host."""

import re
from pathlib import Path

import numpy as np
from numpy.testing import assert_allclose

import celltrain
from celltrain.harmonics import displaced, real_harmonics, surface_points
from celltrain.membrane import reference_coefficients
from celltrain.proximity.boxes import close_boxes
from celltrain.proximity.nearest import nearest_points

DEGREE, PERIOD = 6, 6.0
PLACES = np.array([[0.0, 0.0, 0.0], [0.4, 0.0, 2.0], [0.0, -0.3, 4.5], [9.0, 0.0, 4.0]])


def cells() -> np.ndarray:
    shape = reference_coefficients(DEGREE, "biconcave")
    return displaced(np.repeat(shape[None], len(PLACES), axis=0), PLACES)


def grid() -> tuple[np.ndarray, np.ndarray]:
    """Angles [point, 2] and harmonics of points all over the sphere."""
    random = np.random.default_rng(1)
    angles = np.stack([np.arccos(random.uniform(-1, 1, 150)), random.uniform(0, 6.3, 150)], -1)
    return angles, real_harmonics(DEGREE, *angles.T)


def test_boxes_leave_out_no_close_pair_of_cells() -> None:
    points = surface_points(cells(), grid()[1])
    for within in (0.01, 0.5, 1.5):
        found = list(close_boxes(points, within=within, period=PERIOD))
        assert len(set(found)) == len(found)
        expected = set()
        for first in range(len(points)):
            for second in range(first, len(points)):
                for image in (1,) if first == second else (-1, 0, 1):
                    there = points[second] + [0.0, 0.0, image * PERIOD]
                    apart = np.linalg.norm(points[first][:, None] - there, axis=-1).min()
                    if apart <= within:
                        expected.add((first, second, image))
        assert expected <= set(found)
        # Far away aside, and the nearest image only: boxes do rule out.
        assert len(found) < 18


def test_boxes_of_a_cell_and_its_own_image() -> None:
    points = surface_points(cells()[:1], grid()[1])
    height = np.ptp(points[0, :, 2])
    assert list(close_boxes(points, within=0.3, period=height + 0.29)) == [(0, 0, 1)]
    assert list(close_boxes(points, within=0.3, period=height + 0.31)) == []
    assert list(close_boxes(points, within=0.3, period=0.5 * (height + 0.29), images=2)) == [
        (0, 0, 1),
        (0, 0, 2),
    ]


def test_nearest_points_of_any_number_of_points() -> None:
    shapes = cells()
    angles, values = grid()
    random = np.random.default_rng(4)
    for count in (0, 1, 33, len(angles)):
        number = random.integers(0, len(PLACES), count)
        feet = np.einsum("pk,pik->pi", values[:count], shapes[number])
        centres = PLACES[number]
        # Outward from the middle of the cell, some a little inside.
        away = random.uniform(-0.02, 0.1, count)
        direction = feet - centres
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        points = feet + away[:, None] * direction
        found, distance = nearest_points(points, number, shapes, angles[:count])
        assert found.shape == (count, 2)
        there = np.einsum("pk,pik->pi", real_harmonics(DEGREE, *found.T), shapes[number])
        assert_allclose(np.linalg.norm(points - there, axis=1), np.abs(distance), atol=1e-12)
        assert (np.abs(distance) <= np.abs(away) + 1e-12).all()
        clear = np.abs(distance) > 1e-6
        assert (np.sign(distance) == np.sign(away))[clear].all()


def test_the_glossary_names_what_there_is() -> None:
    root = Path(celltrain.__file__).parents[2]
    text = (root / "docs" / "glossary.md").read_text()
    source = root / "src" / "celltrain"
    code = "\n".join(path.read_text() for path in source.rglob("*.py"))
    rows = [row for row in text.splitlines() if row.startswith("| ") and "`" in row]
    assert len(rows) > 15
    for row in rows:
        for name in re.findall(r"`([^`]+)`", row.split("|")[3]):
            if name.endswith(".py"):
                assert (source / name).is_file(), name
                continue
            for part in name.removeprefix("argument ").split("."):
                assert re.search(rf"\b(def|class) {part}\b|\b{part}: ", code), name
