"""What densities are made of: arithmetic, and nothing else.

A density uses + - * / and ** with constants only. So one formula serves floats and arrays of NumPy,
arrays of JAX, which differentiates it, and second-order jets (`membrane.jets`).
"""

from typing import Any, TypeAlias

#: A float, an array by point, of NumPy or JAX, or a `Jet`.
Number: TypeAlias = Any
