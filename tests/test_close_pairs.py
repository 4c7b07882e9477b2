"""Which targets are close to which cells, and which cells overlap."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from celltrain.harmonics import UNIT_DISPLACEMENT, profile_of
from celltrain.harmonics.grid import sphere_grid
from celltrain.membrane import reference_coefficients
from celltrain.meridian.geometry import size_at_rest
from celltrain.proximity.chunks import CHUNK
from celltrain.proximity.close_pairs import ClosePairs, close_pairs
from celltrain.proximity.overlaps import overlaps
from celltrain.proximity.walls import RoundWall

CELLS, TARGETS, SOURCES, IMAGES = 3, 70, 40, 2
DISTANCE, PERIOD = 0.35, 3.0
UP = np.array([0.0, 0.0, 1.0])


def search(
    targets: np.ndarray, owners: np.ndarray, sources: np.ndarray, capacity: int
) -> ClosePairs:
    @jax.jit
    def compiled(*arguments: jax.Array) -> ClosePairs:
        return close_pairs(
            *arguments, distance=DISTANCE, period=PERIOD, images=IMAGES, capacity=capacity
        )

    return compiled(*map(jnp.asarray, (targets, owners, sources)))


@pytest.fixture(scope="module")
def clouds() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Targets in four groups, the last without a cell, and the grid points of three cells."""
    random = np.random.default_rng(0)
    middles = PERIOD * np.arange(CELLS)[:, None, None] / CELLS * UP
    sources = middles + random.uniform(-0.6, 0.6, (CELLS, SOURCES, 3))
    targets = random.uniform(-1, 1, (CELLS + 1, TARGETS, 3)) * [1, 1, PERIOD]
    targets[:CELLS] += middles
    return targets, np.array([0, 1, 2, -1]), sources


@pytest.fixture(scope="module")
def distances(clouds: tuple[np.ndarray, np.ndarray, np.ndarray]) -> np.ndarray:
    """All distances [image, group, target, cell, source], infinite from a cell to itself."""
    targets, owners, sources = clouds
    displaced = sources + PERIOD * np.arange(-IMAGES, IMAGES + 1)[:, None, None, None] * UP
    apart = targets[None, :, :, None, None] - displaced[:, None, None]
    found = np.linalg.norm(apart, axis=-1)
    for group, owner in enumerate(owners):
        if owner >= 0:
            found[IMAGES, group, :, owner] = np.inf
    return found


def left_out(found: ClosePairs) -> np.ndarray:
    """Which pairs are, [image, group, target, cell]."""
    rows, close = map(np.asarray, (found.left_out.rows, found.left_out.close))
    by_chunk = np.where(rows[..., None] >= 0, close[rows], False)
    by_group = by_chunk.reshape(len(rows), CELLS + 1, -1, CELLS, CHUNK)
    by_target = np.moveaxis(by_group, 3, 4).reshape(len(rows), CELLS + 1, -1, CELLS)
    assert not by_target[:, :, TARGETS:].any()
    return by_target[:, :, :TARGETS]


def test_search_against_all_distances(
    clouds: tuple[np.ndarray, np.ndarray, np.ndarray], distances: np.ndarray
) -> None:
    found = search(*clouds, capacity=1000)
    close = distances.min(axis=-1) < DISTANCE
    assert 50 < found.count == close.sum() == found.valid.sum()
    assert not found.overflow
    np.testing.assert_array_equal(left_out(found), close)
    listed = np.stack([found.image + IMAGES, found.group, found.target, found.cell], axis=-1)
    listed = listed[np.asarray(found.valid)]
    assert {tuple(each) for each in listed} == {tuple(each) for each in np.argwhere(close)}
    nodes = distances[tuple(listed.T)].argmin(axis=-1)
    np.testing.assert_array_equal(found.node[np.asarray(found.valid)], nodes)
    # Pairs of a cell's targets with images of the cell itself are among them.
    assert (found.image[(found.group == found.cell) & found.valid] != 0).any()


def test_a_target_that_is_no_number_changes_no_other(
    clouds: tuple[np.ndarray, np.ndarray, np.ndarray], distances: np.ndarray
) -> None:
    targets, owners, sources = clouds
    close = distances.min(axis=-1) < DISTANCE
    # One that is close to something.
    group, target = np.argwhere(close.any(axis=(0, 3)))[0]
    targets = targets.copy()
    targets[group, target] = np.nan
    close[:, group, target] = False
    found = search(targets, owners, sources, capacity=1000)
    assert not found.overflow
    assert found.count == close.sum()
    np.testing.assert_array_equal(left_out(found), close)


def test_points_of_the_pairs(
    clouds: tuple[np.ndarray, np.ndarray, np.ndarray], distances: np.ndarray
) -> None:
    targets, _, sources = clouds
    found = search(*clouds, capacity=1000)
    valid = np.asarray(found.valid)
    points = np.asarray(found.points(jnp.asarray(targets), PERIOD))
    nearest = np.linalg.norm(points - sources[found.cell, found.node], axis=-1)
    least = distances.min(axis=-1)[found.image + IMAGES, found.group, found.target, found.cell]
    assert_allclose(nearest[valid], least[valid], rtol=1e-12)


def test_too_short_a_list_is_seen(
    clouds: tuple[np.ndarray, np.ndarray, np.ndarray], distances: np.ndarray
) -> None:
    close = distances.min(axis=-1) < DISTANCE
    found = search(*clouds, capacity=20)
    assert found.overflow
    assert found.count == close.sum()
    assert found.valid.all()
    np.testing.assert_array_equal(left_out(found), close)
    exactly = search(*clouds, capacity=int(close.sum()))
    assert not exactly.overflow
    assert exactly.valid.all()


def test_too_few_rows_are_seen(
    clouds: tuple[np.ndarray, np.ndarray, np.ndarray], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("celltrain.proximity.close_pairs.PAIR_CHUNK", 1)
    monkeypatch.setattr("celltrain.proximity.close_pairs.ROWS_PER_CHUNK", 1)
    assert search(*clouds, capacity=1000).overflow


def test_the_first_pair_keeps_its_row_beside_room_for_more() -> None:
    """Of one chunk and two cells the first alone is close; the list has room for both."""
    targets = jnp.zeros((1, 2, 3)).at[0, 1, 0].set(0.5)
    sources = jnp.zeros((2, 1, 3)).at[0, 0, 1].set(0.1).at[1, 0, 2].set(9.0)
    limits = {"distance": 0.2, "period": 20.0, "images": 0, "capacity": 4}
    found = close_pairs(targets, jnp.array([-1]), sources, **limits)
    assert found.count == 1
    assert found.left_out.rows.tolist() == [[[0, -1]]]
    assert found.left_out.close[0, :2].tolist() == [True, False]


def test_nothing_close(clouds: tuple[np.ndarray, np.ndarray, np.ndarray]) -> None:
    targets, owners, sources = clouds
    found = search(targets + 100.0 * np.eye(3)[0], owners, sources, capacity=20)
    assert found.count == 0
    assert not found.valid.any()
    assert not left_out(found).any()


def test_derivatives_do_not_pass_through(
    clouds: tuple[np.ndarray, np.ndarray, np.ndarray],
) -> None:
    targets, owners, sources = map(jnp.asarray, clouds)

    def moved(targets: jax.Array) -> jax.Array:
        found = close_pairs(
            targets,
            owners,
            sources,
            distance=DISTANCE,
            period=PERIOD,
            images=IMAGES,
            capacity=1000,
        )
        return jnp.where(found.valid[:, None], found.points(targets, PERIOD), 0.0)

    step = jnp.ones_like(targets)
    points, change = jax.jit(lambda: jax.jvp(moved, (targets,), (step,)))()
    np.testing.assert_array_equal(change, jnp.where(points != 0.0, 1.0, 0.0))


class TestOverlaps:
    """Biconcave discs of largest radius 1.386, thickest on a ring around their middle."""

    @staticmethod
    def cells(*places: tuple[float, float, float]) -> np.ndarray:
        shapes = np.repeat(reference_coefficients(6, "biconcave")[None], len(places), axis=0)
        shapes[:, :, 0] += UNIT_DISPLACEMENT * np.array(places)
        return shapes

    def test_none(self) -> None:
        # Bounding boxes of the first two overlap; the third fits into the dimples of the second.
        shapes = self.cells((0, 0, 0), (1.95, 1.95, 0.2), (1.95, 1.95, 1.12), (0.0, 0.0, -1.0))
        assert overlaps(shapes, period=2.2, images=1, wall=RoundWall(4.2)) == ()

    def test_names_cells_image_and_place(self) -> None:
        shapes = self.cells((0, 0, 0), (0, 0, 1.2), (0, 0, 2.0))
        found = overlaps(shapes, period=3.4, wall=RoundWall(1.5))
        assert [(each.first, each.second, each.image) for each in found] == [(1, 2, 0)]
        # The grids' points lie where both are thickest, on the same ring: as deep as they can be.
        thickness = size_at_rest(profile_of(reference_coefficients(6, "biconcave")))[1]
        assert found[0].depth == pytest.approx(thickness - 0.8, abs=0.02)
        assert 1.5 < found[0].point[2] < 1.7
        assert "cell 1 and cell 2 overlap" in str(found[0])

    def test_images(self) -> None:
        shapes = self.cells((0, 0, 0), (0.0, 0, 2.0))
        found = overlaps(shapes, period=2.85)
        assert [(each.first, each.second, each.image) for each in found] == [(0, 1, -1)]
        assert -0.5 < found[0].point[2] < -0.35
        assert "displaced by -1 period " in str(found[0])
        found = overlaps(shapes[:1], period=0.85)
        assert [(each.first, each.second, each.image) for each in found] == [(0, 0, 1)]

    def test_side_by_side(self) -> None:
        # Rims meet: the deepest point is on the line between the centres.
        found = overlaps(self.cells((0, 0, 0), (2.7, 0, 0.0)), period=9.0)
        assert [(each.first, each.second, each.image) for each in found] == [(0, 1, 0)]
        assert found[0].depth == pytest.approx(2 * 1.38582 - 2.7, abs=0.02)
        assert_allclose(found[0].point, [1.35, 0, 0], atol=0.1)

    def test_one_inside_the_other(self) -> None:
        shapes = self.cells((0, 0, 0), (0.9, 0, 0.0))
        shapes[1, :, 1:] *= 0.1
        found = overlaps(shapes, period=9.0)
        assert [(each.first, each.second, each.image) for each in found] == [(0, 1, 0)]

    def test_wall(self) -> None:
        found = overlaps(self.cells((0, 0, 0), (0.5, 0, 2.0)), period=9.0, wall=RoundWall(1.8))
        assert [(each.first, each.second) for each in found] == [(1, None)]
        assert found[0].depth == pytest.approx(0.5 + 1.38582 - 1.8, abs=5e-3)
        assert_allclose(found[0].point, [1.886, 0.0, 2.0], atol=0.08)
        assert "cell 1 reaches" in str(found[0])


def test_search_serves_the_rule_on_a_train_of_cells() -> None:
    # Every target of two cells close to each other is found from either side.
    shape = reference_coefficients(6, "biconcave")
    target, source = sphere_grid(6, 8), sphere_grid(6, 15)
    shift = np.array([[0, 0, 0], [0, 0, 1.0]])[:, None]
    points = np.asarray(target.values) @ shape.T + shift
    nodes = np.asarray(source.values) @ shape.T + shift
    found = search(points, np.array([0, 1]), nodes, capacity=200)
    valid = np.asarray(found.valid)
    assert {
        (g, c) for g, c in zip(found.group[valid].tolist(), found.cell[valid].tolist(), strict=True)
    } == {(0, 1), (1, 0)}
    # The mirror image of the pairs of one cell are those of the other.
    assert (found.group[valid] == 0).sum() == (found.group[valid] == 1).sum()
