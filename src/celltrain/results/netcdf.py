"""Results as one self-describing netCDF4 file, and back, bit for bit."""

import tomllib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

import numpy as np
import xarray as xr
from jaxtyping import Complex, Float

from celltrain.parameters import merge_case
from celltrain.results.registry import attributes, quantity
from celltrain.results.replace import replace_file
from celltrain.results.version import version
from celltrain.stability import ErrorBar, Mode, Stability, TransientMode
from celltrain.steady import Base, Iteration
from celltrain.steady.degree import Convergence

_BLOCKS = ("blocks", "eigenvalues", "right_vectors", "left_vectors")
_BASE_SCALARS = (
    "cell_velocity",
    "gap",
    "largest_radius",
    "effective_viscosity",
    "residual",
    "truncation_error",
    "velocity_error",
)
_MODE_TYPES = {
    "growth_rate": float,
    "frequency": float,
    "azimuthal_number": np.int64,
    "wave_number": np.int64,
    "neutral": bool,
    "multiplicity": np.int64,
    "index": np.int64,
    "neutral_kind": str,
}
_BAR_NUMBERS = ("by_degree", "by_rules", "overlap")
_STABILITY_SCALARS = ("spectral_abscissa", "numerical_abscissa", "error_estimate")


def save(result: Base | Stability, path: str | Path) -> Path:
    """Write a result to a netCDF4 file; returns the path.

    The file is written beside its final place and moved there when complete, so that a failure
    leaves nothing half-written, and a file of that name as it was.

    Raises:
        OSError: if the file cannot be written.
    """
    path = Path(path)
    data = dataset(result)
    # No fill values: every number is meant, and an infinite step is no gap in the data.
    encoding = {name: {"_FillValue": None} for name in data.variables}

    def write(part: Path) -> None:
        data.to_netcdf(part, engine="h5netcdf", encoding=encoding)

    replace_file(path, write)
    return path


def load(path: str | Path) -> Base | Stability:
    """Read a result that :func:`save` wrote.

    Raises:
        OSError: if the file cannot be read, or lacks what this version needs.
        ValueError: if it is not a file of this package.
    """
    with xr.open_dataset(path, engine="h5netcdf", decode_times=False) as data:
        data.load()
    kind = data.attrs.get("kind")
    if kind not in ("base", "stability") or "case" not in data.attrs:
        raise ValueError(f"{str(path)!r} is a netCDF file, but holds no result of celltrain")
    with reading(path, data):
        base = _read_base(data)
        return base if kind == "base" else _read_stability(data, base)


@contextmanager
def reading(path: str | Path, data: xr.Dataset) -> Iterator[None]:
    """Say of what a file lacks that it comes from another version.

    Raises:
        OSError: if something is missing from the data that are read meanwhile.
    """
    try:
        yield
    except KeyError as error:
        missing = str(error.args[0]).split(". ")[0]
        writer = data.attrs.get("celltrain_version", "of another version")
        raise OSError(
            f"{str(path)!r} was written by celltrain {writer} and lacks what celltrain {version()}"
            f" needs ({missing}); it has to be computed anew"
        ) from None


def dataset(result: Base | Stability) -> xr.Dataset:
    """The content of the file, with attributes from the registry."""
    stability = result if isinstance(result, Stability) else None
    base = stability.base if stability else result
    assert isinstance(base, Base)
    variables = _base_variables(base) | (_stability_variables(stability) if stability else {})
    arrays = {
        name: xr.Variable(_dims(name), values, attributes(name))
        for name, values in variables.items()
    }
    header = {
        "title": "steady train of cells in a tube" + (", linear dynamics" if stability else ""),
        "kind": "stability" if stability else "base",
        "celltrain_version": version(),
        "units": "length r0 (radius of the sphere of a cell's volume), velocity U (mean velocity in"
        " the tube), viscosity mu (plasma)",
        "case": base.train.to_toml(),
        "origin": base.origin,
    }
    return xr.Dataset(arrays, attrs=header)


def _dims(variable: str) -> tuple[str, ...]:
    """Dimensions of a variable; names of those that depend on m carry it."""
    entry = quantity(variable)
    if not entry.per_azimuthal_number:
        return entry.dims
    suffix = variable.removeprefix(entry.name)[: len("_m00")]
    return tuple(name if name == "wave" else name + suffix for name in entry.dims)


def _base_variables(base: Base) -> dict[str, Any]:
    return {
        "axis": np.array(["x", "y", "z"]),
        "coefficients": base.coefficients,
        **{name: getattr(base, name) for name in _BASE_SCALARS},
        "history_method": _strings(step.method for step in base.history),
        "history_residual": np.array([step.residual for step in base.history], dtype=float),
        "history_step": np.array([step.step for step in base.history], dtype=float),
        "history_cell_velocity": np.array(
            [step.cell_velocity for step in base.history], dtype=float
        ),
        "base_stage": _strings(base.seconds),
        "base_seconds": np.array(list(base.seconds.values()), dtype=float),
    }


def _stability_variables(result: Stability) -> dict[str, Any]:
    variables: dict[str, Any] = {
        "azimuthal_numbers": np.array(result.azimuthal_numbers, dtype=np.int64),
        "wave_numbers": np.asarray(result.wave_numbers),
        **{name: getattr(result, name) for name in _STABILITY_SCALARS},
        "convergence_degrees": np.array(result.convergence.degrees, dtype=np.int64),
        "convergence_least": result.convergence.least,
        "convergence_abscissas": np.array(result.convergence.values, dtype=float),
        "norm": _strings(result.numerical_abscissas),
        "numerical_abscissas": np.array(list(result.numerical_abscissas.values()), dtype=float),
        "stage": _strings(result.seconds),
        "seconds": np.array(list(result.seconds.values()), dtype=float),
    }
    for name in _BLOCKS:
        for number, values in getattr(result, name).items():
            variables |= _parts(f"{name}_m{number:02d}", values)
    for name in _MODE_TYPES:
        column = [getattr(mode, name) for mode in result.modes]
        variables[f"mode_{name}"] = np.array(column, dtype=_MODE_TYPES[name])
    places = [result.modes.index(bar.mode) for bar in result.error_bars]
    variables["bar_mode"] = np.array(places, dtype=np.int64)
    for name in _BAR_NUMBERS:
        numbers = [getattr(bar, name) for bar in result.error_bars]
        variables[f"bar_{name}"] = np.array(numbers, dtype=float)
    for name in ("growth_rate", "azimuthal_number", "wave_number"):
        variables[f"transient_{name}"] = getattr(result.transient, name)
    return variables | _parts("transient_vector", result.transient.vector)


def _read_base(data: xr.Dataset) -> Base:
    history = zip(
        data["history_method"].values,
        data["history_residual"].values,
        data["history_step"].values,
        data["history_cell_velocity"].values,
        strict=True,
    )
    return Base(
        train=merge_case(tomllib.loads(data.attrs["case"]), {}),
        coefficients=data["coefficients"].values,
        history=tuple(
            Iteration(_method(method), float(residual), float(step), float(velocity))
            for method, residual, step, velocity in history
        ),
        origin=data.attrs["origin"],
        seconds=_named(data, "base_stage", "base_seconds"),
        **{name: float(data[name]) for name in _BASE_SCALARS},
    )


def _method(name: Any) -> Literal["march", "newton"]:
    return "march" if name == "march" else "newton"


def _read_stability(data: xr.Dataset, base: Base) -> Stability:
    numbers = tuple(int(number) for number in data["azimuthal_numbers"].values)
    columns = [data[f"mode_{name}"].values.tolist() for name in _MODE_TYPES]

    def blocks(name: str) -> dict[int, Complex[np.ndarray, "..."]]:
        return {number: _whole(data, f"{name}_m{number:02d}") for number in numbers}

    modes = tuple(
        Mode(**dict(zip(_MODE_TYPES, values, strict=True))) for values in zip(*columns, strict=True)
    )
    return Stability(
        base=base,
        azimuthal_numbers=numbers,
        wave_numbers=data["wave_numbers"].values,
        blocks=blocks("blocks"),
        eigenvalues=blocks("eigenvalues"),
        right_vectors=blocks("right_vectors"),
        left_vectors=blocks("left_vectors"),
        modes=modes,
        spectral_abscissa=float(data["spectral_abscissa"]),
        numerical_abscissa=float(data["numerical_abscissa"]),
        error_estimate=float(data["error_estimate"]),
        convergence=Convergence(
            base.train.degree,
            tuple(data["convergence_degrees"].values.tolist()),
            tuple(data["convergence_abscissas"].values.tolist()),
            float(data["convergence_least"]),
        ),
        numerical_abscissas=_named(data, "norm", "numerical_abscissas"),
        transient=TransientMode(
            growth_rate=float(data["transient_growth_rate"]),
            azimuthal_number=int(data["transient_azimuthal_number"]),
            wave_number=int(data["transient_wave_number"]),
            vector=_whole(data, "transient_vector"),
        ),
        seconds=_named(data, "stage", "seconds"),
        error_bars=_read_bars(data, modes),
    )


def _read_bars(data: xr.Dataset, modes: tuple[Mode, ...]) -> tuple[ErrorBar, ...]:
    """The error bars; none in files of versions that had none."""
    if "bar_mode" not in data:
        return ()
    columns = [data[f"bar_{name}"].values.tolist() for name in _BAR_NUMBERS]
    return tuple(
        ErrorBar(modes[place], *numbers)
        for place, *numbers in zip(data["bar_mode"].values.tolist(), *columns, strict=True)
    )


def _parts(name: str, values: Complex[np.ndarray, "..."]) -> dict[str, Float[np.ndarray, "..."]]:
    """A complex array as two real ones, because netCDF knows no complex numbers."""
    return {f"{name}_real": values.real, f"{name}_imag": values.imag}


def _whole(data: xr.Dataset, name: str) -> Complex[np.ndarray, "..."]:
    """The complex array again; arithmetic with 1j would lose the signs of zeros."""
    real = data[f"{name}_real"].values
    values = np.empty(real.shape, dtype=complex)
    values.real, values.imag = real, data[f"{name}_imag"].values
    return values


def _named(data: xr.Dataset, names: str, values: str) -> dict[str, float]:
    pairs = zip(data[names].values, data[values].values, strict=True)
    return {str(name): float(value) for name, value in pairs}


def _strings(values: Iterable[str]) -> np.ndarray:
    return np.array(list(values), dtype=str)
