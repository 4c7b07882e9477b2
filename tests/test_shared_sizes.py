"""Sizes that many tubes share: enough of them, few of them, and the same velocities."""

import jax
import numpy as np

from celltrain import Train
from celltrain.flow.shared_sizes import shared_size
from celltrain.train import train_operator


def test_sizes_suffice_and_are_few():
    sizes = [shared_size(count) for count in range(1, 1001)]
    assert all(1 <= size / count <= 2.0 for count, size in enumerate(sizes, 1))
    assert all(size / count <= 1.4 for count, size in enumerate(sizes, 1) if count > 7)
    assert all(shared_size(size) == size for size in sizes)
    assert len(set(sizes)) < 30


def test_neighbours_in_a_map_share_their_programs():
    """A program belongs to the shapes of the operator's arrays and to what is static in it."""

    def kind(diameter: float, packing: float) -> tuple[object, ...]:
        train = Train(diameter=diameter, packing=packing, degree=8)
        operator = train_operator(train, phase=0.3, close=False)
        shapes, tree = jax.tree.flatten(jax.tree.map(np.shape, operator))
        return (*shapes, tree)

    diameters = np.linspace(6.0, 12.0, 7)
    packings = np.linspace(0.2, 0.7, 11)
    kinds = {kind(float(d), float(phi)) for d in diameters for phi in packings}
    assert len(kinds) <= 30
    assert kind(9.0, 0.65) == kind(11.0, 0.7)
