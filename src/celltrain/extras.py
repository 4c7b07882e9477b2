"""What is installed only with an extra of the package, and what is said where it is missing."""

from importlib.util import find_spec

#: For each extra the modules that it brings, and what needs them.
EXTRAS: dict[str, tuple[tuple[str, ...], str]] = {
    "simulations": (
        ("jax", "jaxlib", "equinox"),
        "simulations and velocities in the fluid need JAX and Equinox",
    ),
    "explore": (("dash", "plotly"), "the explorer and pages of results need Dash and Plotly"),
    "studies": (("distributed",), "studies need dask.distributed"),
}


class MissingExtra(ImportError):
    """Something is asked for that needs an extra which is not installed; the message names it."""


def check_installed(extra: str) -> None:
    """Look whether an extra is installed, without importing any of it.

    Raises:
        MissingExtra: if a part of it is not there.
    """
    modules, need = EXTRAS[extra]
    missing = [name for name in modules if find_spec(name) is None]
    if missing:
        raise MissingExtra(
            f"{need}; not installed: {', '.join(missing)}."
            f" To install: python -m pip install 'celltrain[{extra}]'"
        )
