"""The loops by their names; each is made when a program first wants it.

Making one takes Numba seconds, unless it has kept the machine code: no program waits for loops that
it does without.
"""

from functools import partial
from importlib import import_module

from celltrain.programs import offer

# Names under which XLA finds the loops.
FORCE_PAIRS = "celltrain_force_pairs"
STRESSLET_PAIRS = "celltrain_stresslet_pairs"
OWN_FORCES = "celltrain_own_forces"
OWN_DOUBLE_LAYER = "celltrain_own_double_layer"
CLOSE_FORCES = "celltrain_close_forces"
NEAREST = "celltrain_nearest"

#: The module of each.
MODULES = {
    FORCE_PAIRS: "force_pair_loop",
    STRESSLET_PAIRS: "stresslet_pair_loop",
    OWN_FORCES: "own_surface_loop",
    OWN_DOUBLE_LAYER: "own_double_layer_loop",
    CLOSE_FORCES: "close_loop",
    NEAREST: "nearest_loop",
}


def make(name: str) -> None:
    """Let XLA find a loop, which is compiled now unless it is kept; others are known already."""
    if name in MODULES:
        import_module(f"celltrain.compiled.{MODULES[name]}")


for _name in MODULES:
    offer(_name, partial(make, _name))
