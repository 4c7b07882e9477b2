"""Files of a simulation: for ParaView, read back, and pictures and films."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from drawn import saved
from matplotlib.animation import FFMpegWriter
from numpy.testing import assert_allclose
from PIL import Image

from celltrain.harmonics import UNIT_DISPLACEMENT
from celltrain.membrane import place_cells, reference_coefficients
from celltrain.parameters import CaseError, Train
from celltrain.pictures import evolution
from celltrain.pictures.animation import animate
from celltrain.pictures.evolution import WIDE, Growth, draw_snapshots, make_scene, plot_growth
from celltrain.pictures.paraview import PolyData, closed_rings, export_paraview, write_poly_data

TYPES = {"Float32": np.dtype("<f4"), "Int32": np.dtype("<i4")}


def read_poly_data(path: Path) -> PolyData:
    """What a .vtp file holds; fails where the format is not kept."""
    before, found, rest = path.read_bytes().partition(b'<AppendedData encoding="raw">_')
    assert found
    content, found, after = rest.rpartition(b"</AppendedData>")
    assert found
    root = ElementTree.fromstring(before + after)
    assert root.tag == "VTKFile"
    assert root.attrib["type"] == "PolyData"
    assert root.attrib["byte_order"] == "LittleEndian"
    assert root.attrib["header_type"] == "UInt64"
    piece = root.find("PolyData/Piece")
    assert piece is not None

    end = 0

    def array(element: ElementTree.Element) -> np.ndarray:
        nonlocal end
        assert element.attrib["format"] == "appended"
        begin = int(element.attrib["offset"])
        (size,) = np.frombuffer(content[begin : begin + 8], "<u8")
        values = np.frombuffer(
            content[begin + 8 : begin + 8 + int(size)], TYPES[element.attrib["type"]]
        )
        assert values.nbytes == size
        end = max(end, begin + 8 + int(size))
        components = int(element.attrib["NumberOfComponents"])
        return values.reshape(-1, components) if components > 1 else values

    points = array(piece.findall("Points/DataArray")[0])
    polygons = {each.attrib["Name"]: array(each) for each in piece.findall("Polys/DataArray")}
    assert int(piece.attrib["NumberOfPoints"]) == len(points)
    assert int(piece.attrib["NumberOfPolys"]) == len(polygons["offsets"])
    assert all(piece.attrib[f"NumberOf{kind}"] == "0" for kind in ("Verts", "Lines", "Strips"))
    data = {each.attrib["Name"]: array(each) for each in piece.findall("PointData/DataArray")}
    assert all(len(each) == len(points) for each in data.values())
    assert end == len(content)
    return PolyData(points, polygons["connectivity"], polygons["offsets"], data)


def triangles(data: PolyData) -> np.ndarray:
    """The polygons cut into triangles [triangle, corner]."""
    found = []
    for polygon in np.split(data.polygons, data.offsets[:-1]):
        found += [(polygon[0], polygon[i], polygon[i + 1]) for i in range(1, len(polygon) - 1)]
    return np.array(found)


@pytest.fixture(scope="module")
def train() -> Train:
    return Train(diameter=6, packing=0.3, cells=3, degree=6, reference="sphere")


@pytest.fixture(scope="module")
def shapes(train: Train) -> np.ndarray:
    """Two frames [time, cell, 3, coefficient] of inflated spheres, the second moved."""
    first = place_cells(1.1 * reference_coefficients(6, "sphere"), train, 3)
    second = first.copy()
    second[:, 0, 0] += UNIT_DISPLACEMENT * np.array([0.1, 0.2, 0.3])
    second[:, 2, 0] += UNIT_DISPLACEMENT * 4.0
    return np.stack([first, second])


@pytest.fixture(scope="module")
def exported(train: Train, shapes: np.ndarray, tmp_path_factory: pytest.TempPathFactory) -> Path:
    rates = np.zeros_like(shapes)
    # Cells move at 1.7 along the tube and turn at 0.5 about it.
    rates[:, :, 2, 0] = 1.7 * UNIT_DISPLACEMENT
    rates[:, :, 0], rates[:, :, 1] = -0.5 * shapes[:, :, 1], 0.5 * shapes[:, :, 0]
    folder = tmp_path_factory.mktemp("run") / "new" / "folder"
    return export_paraview(train, np.array([0.0, 2.5]), shapes, rates, folder)


def test_collection_names_every_frame_with_its_time(exported: Path) -> None:
    entries = ElementTree.parse(exported).getroot().findall("Collection/DataSet")
    assert [float(each.attrib["timestep"]) for each in entries] == [0.0, 2.5]
    assert [each.attrib["file"] for each in entries] == ["cells_00000.vtp", "cells_00001.vtp"]
    assert all((exported.parent / each.attrib["file"]).exists() for each in entries)


def test_cells_are_closed_and_face_outwards(exported: Path) -> None:
    data = read_poly_data(exported.parent / "cells_00001.vtp")
    faces = triangles(data)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    # Each edge once in each direction, and every point used.
    assert len({tuple(edge) for edge in edges}) == len(edges)
    assert {tuple(edge) for edge in edges} == {tuple(edge[::-1]) for edge in edges}
    assert set(faces.ravel()) == set(range(len(data.points)))
    # No polygon joins two cells.
    assert (data.point_data["cell"][faces] == data.point_data["cell"][faces[:, :1]]).all()
    points = data.points.astype(float)
    for cell in range(3):
        mine = faces[data.point_data["cell"][faces[:, 0]] == cell]
        corners = points[mine] - points[mine[0, 0]]
        volume = np.sum(corners[:, 0] * np.cross(corners[:, 1], corners[:, 2])) / 6
        assert volume == pytest.approx(4 / 3 * np.pi * 1.1**3, rel=0.02)


def test_points_carry_velocity_and_tension(exported: Path, train: Train) -> None:
    data = read_poly_data(exported.parent / "cells_00001.vtp")
    centres = np.array([[0.1 * (1 + i), 0, 4 + i / 0.3] for i in range(3)])
    offset = data.points - centres[data.point_data["cell"]]
    assert_allclose(np.linalg.norm(offset, axis=1), 1.1, rtol=1e-5)
    x, y = data.points[:, 0], data.points[:, 1]
    assert_allclose(
        data.point_data["velocity"],
        np.stack([-0.5 * y, 0.5 * x, np.full_like(x, 1.7)], axis=-1),
        atol=1e-5,
    )
    relative = np.stack([-0.5 * offset[:, 1], 0.5 * offset[:, 0], 0 * x], axis=-1)
    assert_allclose(data.point_data["relative_velocity"], relative, atol=1e-5)
    # The tension of an inflated sphere, d(energy)/d(area), the same at the poles.
    size, law = 1.1, train.cell
    first, second = 2 * size**2 - 2, size**4 - 1
    slope = (
        law.shear_modulus / 8 * ((2 * first + 2) * 4 * size - 2 * 4 * size**3)
        + law.dilatation_modulus / 8 * 2 * second * 4 * size**3
    )
    assert_allclose(data.point_data["tension"], slope / (2 * size), rtol=1e-5)


def test_values_at_the_poles_continue_those_beside_them(tmp_path: Path, train: Train) -> None:
    """A cell with uneven tension: the pole's value lies on a parabola through the next rings."""
    shape = reference_coefficients(6, "sphere")
    # Longer along the axis, and bent.
    shape[2] *= 1.2
    shape[0, 6] += 0.1
    path = export_paraview(train, np.zeros(1), shape[None, None], np.zeros((1, 1, 3, 36)), tmp_path)
    tension = read_poly_data(path.parent / "cells_00000.vtp").point_data["tension"]
    rings = tension[1:-1].reshape(train.sizes.energy_order, -1).mean(axis=1)
    assert np.ptp(tension) > 0.5
    theta = np.arccos(np.polynomial.legendre.leggauss(len(rings))[0][::-1])
    for pole, near, angle in (
        (tension[0], rings[:3], theta[:3]),
        (tension[-1], rings[:-4:-1], np.pi - theta[:-4:-1]),
    ):
        parabola = np.polynomial.polynomial.polyfit(angle**2, near, 2)
        assert pole == pytest.approx(parabola[0], abs=1e-3)


def test_wall_is_a_tube(exported: Path) -> None:
    data = read_poly_data(exported.parent / "tube.vtp")
    assert_allclose(np.hypot(data.points[:, 0], data.points[:, 1]), 3.0, rtol=1e-6)
    assert data.points[:, 2].min() < -1.2
    assert data.points[:, 2].max() > 4 + 2 / 0.3 + 1.2
    assert (np.diff(data.offsets, prepend=0) == 4).all()


def test_a_surface_of_rings_has_the_topology_of_a_sphere() -> None:
    polygons, offsets = closed_rings(5, 8)
    assert set(polygons) == set(range(42))
    corners = np.split(polygons, offsets[:-1])
    edges = {
        frozenset((int(a), int(b)))
        for each in corners
        for a, b in zip(each, np.roll(each, -1), strict=True)
    }
    assert 42 - len(edges) + len(corners) == 2


def test_a_single_surface_is_read_back(tmp_path: Path) -> None:
    data = PolyData(
        np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]),
        np.arange(3),
        np.array([3]),
        {"number": np.arange(3), "vector": np.eye(3)},
    )
    write_poly_data(data, tmp_path / "one.vtp")
    found = read_poly_data(tmp_path / "one.vtp")
    assert_allclose(found.points, data.points)
    assert found.point_data["number"].dtype == np.int32
    assert_allclose(found.point_data["vector"], np.eye(3))


def test_frames_that_do_not_fit_are_refused(
    train: Train, shapes: np.ndarray, tmp_path: Path
) -> None:
    with pytest.raises(CaseError, match="at least one time"):
        export_paraview(train, np.zeros(3), shapes, shapes, tmp_path)
    with pytest.raises(CaseError, match="degree 6"):
        export_paraview(train, np.zeros(2), shapes[..., :25], shapes[..., :25], tmp_path)
    with pytest.raises(CaseError, match="one time for each frame"):
        draw_snapshots(train, np.zeros(1), shapes).savefig(tmp_path / "some.png")
    assert not list(tmp_path.iterdir())


def size_of(path: Path) -> tuple[int, int]:
    with Image.open(path) as picture:
        picture.verify()
        return picture.size


def test_growth_is_drawn(train: Train, tmp_path: Path) -> None:
    times = np.linspace(0, 50, 20)
    size = 1e-3 * np.exp(0.1 * times)
    before = dict(mpl.rcParams)
    path = saved(
        plot_growth(train, Growth(times, size, 0.6 * size, 0.1, 1.1 * size)), tmp_path / "g.png"
    )
    assert size_of(path) == (1440, 920)
    assert size_of(saved(plot_growth(train, Growth(times, size)), tmp_path / "h.png")) == (
        1440,
        920,
    )
    assert (tmp_path / "g.png").stat().st_size > (tmp_path / "h.png").stat().st_size
    assert dict(mpl.rcParams) == before
    with pytest.raises(CaseError, match="as many values"):
        plot_growth(train, Growth(times, size[1:])).savefig(tmp_path / "i.png")


def test_snapshots_are_drawn(
    train: Train, shapes: np.ndarray, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    times = np.array([0.0, 2.5])
    one = size_of(saved(draw_snapshots(train, times[:1], shapes[:1]), tmp_path / "one.png"))
    moving = draw_snapshots(train, times, shapes, velocities=0.1 * shapes[..., 0])
    both = size_of(saved(moving, tmp_path / "both.png"))
    # This tube is short and wide: two of them make a row, of half the height.
    assert make_scene(train, shapes).ratio > WIDE
    assert both[0] == one[0]
    assert 0.5 * one[1] < both[1] < one[1]
    # Of a long tube each has a row of its own.
    monkeypatch.setattr(evolution, "WIDE", np.inf)
    below = size_of(saved(draw_snapshots(train, times, shapes), tmp_path / "below.png"))
    assert below[0] == one[0]
    assert below[1] > 1.6 * one[1]


def test_cells_that_leave_downstream_enter_upstream(train: Train, shapes: np.ndarray) -> None:
    scene = make_scene(train, shapes)
    start, end = scene.tube.start, scene.tube.end
    assert end - start == pytest.approx(train.length)
    height = scene.placed(shapes[1])[:, 2, 0] / UNIT_DISPLACEMENT
    assert ((height >= start) & (height < end)).all()
    moved = (height - shapes[1, :, 2, 0] / UNIT_DISPLACEMENT) / train.length
    assert_allclose(moved, np.round(moved), atol=1e-12)
    assert_allclose(moved, [0, 0, -1], atol=1e-12)
    # A short train is repeated.
    single = make_scene(train, shapes[:, :1])
    assert single.repeats == 3
    again = single.placed(shapes[0, :1])[:, 2, 0] / UNIT_DISPLACEMENT
    assert_allclose(np.diff(again), train.period)


def test_film_has_every_frame(train: Train, shapes: np.ndarray, tmp_path: Path) -> None:
    path = animate(train, np.array([0.0, 2.5]), shapes, tmp_path / "film.gif")
    with Image.open(path) as film:
        assert film.n_frames == 2
        first = np.asarray(film.convert("RGB")).astype(int)
        film.seek(1)
        second = np.asarray(film.convert("RGB")).astype(int)
    # Cells are red in both, at other places.
    red = [each[..., 0] - each[..., 2] > 60 for each in (first, second)]
    assert all(each.mean() > 0.02 for each in red)
    assert (red[0] != red[1]).mean() > 0.01


def test_films_that_cannot_be_made_are_refused(
    train: Train, shapes: np.ndarray, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(FFMpegWriter, "isAvailable", classmethod(lambda cls: False))
    with pytest.raises(CaseError, match="ffmpeg"):
        animate(train, np.zeros(2), shapes, tmp_path / "film.mp4")
    with pytest.raises(CaseError, match=r"allowed are \.gif and \.mp4"):
        animate(train, np.zeros(2), shapes, tmp_path / "film.avi")
