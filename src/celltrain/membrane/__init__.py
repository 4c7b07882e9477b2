"""The cell membrane: its energy and force by the laws of `laws`, and the shapes at rest.

What is here needs NumPy and SciPy only, and serves axisymmetric cells. The membrane of a cell of
any shape, in JAX, is in `energy`, its surface in `geometry`; both are modules to import by name.
"""

from celltrain.membrane.axisymmetric import AxisymmetricMembrane, axisymmetric_membrane
from celltrain.membrane.equilibrium import healthy_reduced_volume, relaxed_slope
from celltrain.membrane.forms import PointwiseEnergy
from celltrain.membrane.material import cell_material, with_moduli
from celltrain.membrane.reference import reference_coefficients
from celltrain.membrane.resting import resting_shape
from celltrain.membrane.train_cells import meridian_membrane, place_cells

__all__ = [
    "AxisymmetricMembrane",
    "PointwiseEnergy",
    "axisymmetric_membrane",
    "cell_material",
    "healthy_reduced_volume",
    "meridian_membrane",
    "place_cells",
    "reference_coefficients",
    "relaxed_slope",
    "resting_shape",
    "with_moduli",
]
