"""What numbers mean: each field of a result carries its symbol, unit and meaning.

    cell_velocity: Annotated[float, Quantity("U_c", "U", "velocity of the steady train")]

Files, JSON, reports, labels of pictures, columns of studies and the documentation take them there.
"""

from celltrain.quantities.fields import Named, numbers, quantities, quantity_of
from celltrain.quantities.quantity import Quantity, quantity
from celltrain.quantities.record import Record, equal

__all__ = [
    "Named",
    "Quantity",
    "Record",
    "equal",
    "numbers",
    "quantities",
    "quantity",
    "quantity_of",
]
