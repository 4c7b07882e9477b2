"""What the first file takes beyond its writing, done by another thread beforehand."""

from contextlib import suppress
from threading import Thread


def prepare() -> None:
    """Load what writing a file needs: half a second, while this thread has better things to do."""
    Thread(target=_write_something, daemon=True).start()


def _write_something() -> None:
    # Whatever goes wrong will go wrong again where it is asked for.
    with suppress(Exception):
        import xarray as xr

        from celltrain.results.netcdf import content_of

        content_of(xr.Dataset({"something": ((), 0.0)}))
