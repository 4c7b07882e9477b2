from collections.abc import Callable
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from drawn import saved
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from celltrain.contract import draw_all
from celltrain.harmonics import UNIT_DISPLACEMENT
from celltrain.pictures import (
    draw_base_train,
    draw_leading_mode,
    draw_profile,
    draw_spectrum,
    draw_transient_mode,
)
from celltrain.pictures.camera import Camera
from celltrain.pictures.disturbance import draw_amplitude, turned
from celltrain.pictures.render import Light, draw_surfaces
from celltrain.pictures.surface import surface
from celltrain.stability import Stability
from celltrain.steady import Base

PNG = b"\x89PNG\r\n\x1a\n"


def assert_picture(path: Path) -> None:
    content = path.read_bytes()
    assert content.startswith(PNG)
    assert len(content) > 10_000


def sphere(degree: int) -> np.ndarray:
    """The unit sphere: x, y, z are the harmonics of degree 1, up to their norm."""
    coefficients = np.zeros((3, degree**2))
    norm = np.sqrt(4 * np.pi / 3)
    coefficients[0, 3] = coefficients[1, 1] = coefficients[2, 2] = norm
    return coefficients


def side_camera() -> Camera:
    return Camera(np.zeros(3), distance=30.0, yaw=0.0, elevation=0.0)


def test_all_pictures_of_a_base(make_base: Callable[..., Base], tmp_path: Path) -> None:
    paths = draw_all(make_base(), tmp_path / "new" / "folder")
    assert [path.stem for path in paths] == ["base_train", "profile"]
    for path in paths:
        assert_picture(path)


def test_all_pictures_of_a_stability(
    make_stability: Callable[..., Stability], tmp_path: Path
) -> None:
    paths = draw_all(make_stability(), tmp_path)
    assert [path.stem for path in paths] == [
        "base_train",
        "profile",
        "spectrum",
        "leading_mode",
        "transient_mode",
    ]
    for path in paths:
        assert_picture(path)


@pytest.mark.parametrize("cells", [1, 2, 15])
def test_short_and_long_trains_are_drawn(
    cells: int, make_stability: Callable[..., Stability], tmp_path: Path
) -> None:
    result = make_stability(cells=cells)
    assert_picture(saved(draw_base_train(result.base), tmp_path / "train.png"))
    assert_picture(saved(draw_leading_mode(result), tmp_path / "mode.png"))
    assert_picture(saved(draw_transient_mode(result), tmp_path / "transient.png"))


def test_dense_train_and_one_sided_spectrum_are_drawn(
    make_stability: Callable[..., Stability], tmp_path: Path
) -> None:
    result = make_stability(growth=-0.02, packing=0.6)
    assert_picture(saved(draw_profile(result.base), tmp_path / "profile.png"))
    assert_picture(saved(draw_spectrum(result), tmp_path / "spectrum.png"))


def test_settings_of_matplotlib_are_left_alone(
    make_stability: Callable[..., Stability], tmp_path: Path
) -> None:
    before = dict(mpl.rcParams)
    draw_all(make_stability(), tmp_path)
    assert dict(mpl.rcParams) == before


def test_mesh_of_a_sphere() -> None:
    mesh = surface(6, 20, 30)
    vertices = mesh.vertices(sphere(6))
    assert mesh.faces.shape == (600, 4)
    np.testing.assert_allclose(np.linalg.norm(vertices, axis=-1), 1.0, atol=1e-12)
    # Outward, also at the poles.
    assert ((mesh.normals(vertices) * vertices).sum(-1) > 0.99).all()


def test_half_of_a_closed_surface_is_drawn_farthest_first() -> None:
    mesh = surface(6, 20, 30)
    ball = mesh.vertices(sphere(6))
    vertices = np.stack([ball, ball + np.array([0.0, 0.0, 3.0])])
    normals = np.stack([mesh.normals(ball)] * 2)
    axes = Figure().add_subplot()
    polygons = draw_surfaces(axes, side_camera(), vertices, normals, mesh.faces)
    assert isinstance(polygons, PolyCollection)
    drawn = len(polygons.get_paths())
    assert 0.4 * 1200 < drawn <= 0.5 * 1200
    assert len(polygons.get_facecolor()) == drawn


def test_camera_keeps_right_up_and_near() -> None:
    camera = side_camera()
    flat, depth = camera.project(np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]))
    np.testing.assert_allclose(flat, [[1, 0], [0, 1], [0, 0]], atol=1e-12)
    np.testing.assert_allclose(depth, [0, 0, 1], atol=1e-12)
    # What is nearer looks larger.
    larger, _ = camera.project(np.array([-5.0, 1.0, 0.0]))
    assert larger[1] > 1.1


def test_lit_side_is_brighter() -> None:
    light, camera = Light(), side_camera()
    normals = np.array([light.key, -light.key]) @ [camera.right, camera.up, camera.backward]
    bright, dark = light.shade(np.zeros((2, 3)), normals, np.array([0.8, 0.1, 0.1]), camera)
    assert bright.sum() > 1.5 * dark.sum()


def shift_sideways(cells: int, degree: int = 6) -> np.ndarray:
    """All cells move along x by one."""
    disturbance = np.zeros((cells, 3, degree**2))
    disturbance[:, 0, 0] = UNIT_DISPLACEMENT
    return disturbance


def test_disturbance_is_drawn_as_large_as_asked_and_in_the_plane_of_the_picture() -> None:
    drawn = draw_amplitude(
        sphere(6),
        3.0 * shift_sideways(2),
        period=5.0,
        radius=3.0,
        camera=side_camera(),
        displacement=0.5,
    )
    assert drawn.displacement == pytest.approx(0.5)
    assert drawn.amplitude == pytest.approx(0.5 / 3)
    # The shift along x, towards the eye, is turned until it is along y.
    centre = drawn.coefficients[0, :, 0] / UNIT_DISPLACEMENT
    np.testing.assert_allclose(np.abs(centre), [0, 0.5, 0], atol=1e-6)


def test_disturbance_is_drawn_smaller_where_the_wall_is_near() -> None:
    drawn = draw_amplitude(
        sphere(6), shift_sideways(2), period=5.0, radius=1.3, camera=side_camera()
    )
    assert 0.1 < drawn.displacement < 0.3


def test_disturbance_is_drawn_smaller_where_cells_would_overlap() -> None:
    disturbance = np.zeros((2, 3, 36))
    disturbance[0, 2, 0], disturbance[1, 2, 0] = UNIT_DISPLACEMENT, -UNIT_DISPLACEMENT
    drawn = draw_amplitude(sphere(6), disturbance, period=2.4, radius=3.0, camera=side_camera())
    assert 0.1 <= drawn.displacement < 0.2


def test_nothing_cannot_be_drawn() -> None:
    with pytest.raises(ValueError, match="moves nothing"):
        draw_amplitude(
            sphere(6), 0 * shift_sideways(2), period=5.0, radius=3.0, camera=side_camera()
        )


def test_turning_is_rigid() -> None:
    shape = np.random.default_rng(0).normal(size=(2, 3, 36))
    np.testing.assert_allclose(turned(turned(shape, 0.4), -0.4), shape, atol=1e-14)
    np.testing.assert_allclose(turned(shape, np.pi / 2)[:, 1], shape[:, 0], atol=1e-14)


def test_a_picture_has_its_own_style(make_base: Callable[..., Base]) -> None:
    users = {"xtick.direction": "out", "axes.titlesize": 30, "figure.dpi": 50}
    # What the style says nothing of is Matplotlib's own, not the user's.
    users |= {"axes.labelsize": 31, "axes.facecolor": "black"}
    with mpl.rc_context(users):
        figure = draw_profile(make_base())
        assert mpl.rcParams["axes.titlesize"] == 30
    [axes] = figure.axes
    assert figure.dpi == 200
    assert axes.xaxis.get_major_ticks()[0].get_tickdir() == "in"
    assert axes.get_facecolor() == (1.0, 1.0, 1.0, 1.0)
    assert axes.xaxis.label.get_size() < 30
    assert axes.get_title(loc="left").startswith("$D$ = ")
