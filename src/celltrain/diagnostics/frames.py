"""All measures of one frame of a simulation."""

from functools import lru_cache

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from celltrain.diagnostics.ellipsoid import best_ellipsoid
from celltrain.diagnostics.energy import energy_parts
from celltrain.diagnostics.moments import cell_moments
from celltrain.diagnostics.quantities import ENERGY_PARTS, FRAME_QUANTITIES
from celltrain.diagnostics.rotation import cell_motion
from celltrain.diagnostics.spectrum import deformation_spectrum
from celltrain.harmonics.jax_shapes import JaxShape, JaxShapes
from celltrain.membrane.energy import Membrane
from celltrain.parameters import CaseError, Train
from celltrain.programs import Program
from celltrain.proximity.distances import cell_distance, wall_distance
from celltrain.surroundings import train_tube
from celltrain.train import train_membrane


def frame(
    train: Train,
    shapes: Float[Array | np.ndarray, "cell 3 coefficient"],
    rates: Float[Array | np.ndarray, "cell 3 coefficient"],
) -> dict[str, np.ndarray]:
    """Everything that is recorded of the cells at one time.

    **Arguments:**

    - `train`: the case; the period is that of as many cells as there are shapes.
    - `shapes`: coefficients of each cell in its place, in r0.
    - `rates`: ds/dt, in U; velocities of centroids are in their frame.

    **Returns:** an array for each name in `FRAME_QUANTITIES`, whose dimensions and units stand
    there.

    **Raises:** `CaseError` for shapes of another degree than the train's, or not finite.
    """
    shapes, rates = np.asarray(shapes, dtype=float), np.asarray(rates, dtype=float)
    degree = train.degree
    if shapes.shape[1:] != (3, degree**2) or rates.shape != shapes.shape:
        raise CaseError(
            f"shapes {shapes.shape} and rates {rates.shape} are not allowed: a train of degree"
            f" {degree} has [cell, 3, {degree**2}]"
        )
    if not np.isfinite(shapes).all():
        raise CaseError(
            "shapes with NaN or infinite coefficients are not allowed; allowed: finite ones"
        )
    measures = _measure(_membrane(train), jnp.asarray(shapes), jnp.asarray(rates))
    measured = {name: np.asarray(each) for name, each in measures.items()}
    placed = shapes.copy()
    placed[..., 0] = 0.0
    measured["shape_spectrum"] = deformation_spectrum(placed)
    measured["wall_distance"] = wall_distance(shapes, train_tube(train).wall)
    measured["cell_distance"] = cell_distance(shapes, len(shapes) * train.period)
    return {name: measured[name] for name in FRAME_QUANTITIES}


@lru_cache(maxsize=4)
def _membrane(train: Train) -> Membrane:
    return train_membrane(train)


@Program
def _measure(
    membrane: Membrane,
    shapes: JaxShapes,
    rates: JaxShapes,
) -> dict[str, Float[Array, "cell ..."]]:
    """What comes from integrals over each membrane."""

    def one(shape: JaxShape, rate: JaxShape) -> dict[str, Float[Array, "..."]]:
        moments = cell_moments(membrane, shape)
        ellipsoid = best_ellipsoid(moments.solid)
        motion = cell_motion(membrane, shape, rate)
        energies = energy_parts(membrane, shape)
        return {
            "centroid": moments.centroid,
            "centroid_velocity": motion.centroid_velocity,
            "cell_volume": moments.volume,
            "cell_area": moments.area,
            "semi_axes": ellipsoid.semi_axes,
            "principal_axes": ellipsoid.axes,
            "inclination": ellipsoid.inclination,
            "rotation_rate": motion.rotation_rate,
            "membrane_rotation_rate": motion.membrane_rotation_rate,
            "tumbling": motion.tumbling,
            "tank_treading": motion.tank_treading,
            **{f"energy_{name}": energies[i] for i, name in enumerate(ENERGY_PARTS)},
        }

    return jax.vmap(one)(shapes, rates)
