"""How much the repulsion acted in a simulation."""

import math

import numpy as np

from celltrain.evolution.record.run import Run


def repulsion_record(run: Run) -> dict[str, float]:
    """How much the repulsion acted, as far as the ends of steps tell.

    When it began ("since", r0/U, nan if it did not) and for how long ("duration", r0/U), the
    thinnest film ("smallest_gap", r0, infinite if there was none), the largest force of films on a
    cell (mu U r0) and the largest energy of all films over that of the membranes.
    """
    history = run.history
    acts = np.isfinite(history["gap"])
    return {
        "since": float(history["time"][np.argmax(acts)]) if acts.any() else math.nan,
        "duration": float(history["size"][acts].sum()),
        "smallest_gap": float(history["gap"].min()),
        "largest_force": float(history["film_force"].max()),
        "largest_energy_share": float((history["film_energy"] / history["energy"]).max()),
    }
