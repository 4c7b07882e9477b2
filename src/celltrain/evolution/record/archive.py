"""A simulation's file: one netCDF-4 file that is whole at every moment.

The file is never changed in place: everything that is known, the state to go on from included,
replaces it at once (see `results.replace`). The price is that each save writes all frames again
(27 kB for each frame of eight cells at degree 12), which `evolve` bounds by saving less often as
saving takes longer.
"""

from pathlib import Path

from celltrain.evolution.record.run import Run
from celltrain.results import save

#: Wall time between saves, unless told otherwise.
SAVE_SECONDS = 30.0


class Archive:
    """The file of one simulation."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def save(self, run: Run) -> None:
        """Replace the file by one with all of a simulation.

        **Raises:** `OSError` if it cannot be written; the old file is left as it was.
        """
        save(run, self._path)

    def where(self, run: Run) -> str:
        """How much of a simulation is where, in words."""
        return f"all until t = {run.state.time:.6g} r0/U is in {self._path}"
