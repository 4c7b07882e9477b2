"""What the leading mode and the disturbance that grows fastest at first do to the cells."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float
from matplotlib.figure import Figure

from celltrain.diagnostics import ENERGY_PARTS, ModeMotion, deformation_spectrum, mode_motion
from celltrain.stability import Mode, Stability

#: Modes whose turning is drawn.
MODES = 8
NAMES = (r"$v_\alpha$, leading mode", r"$v_\eta$, fastest at first")
COLORS = ("#0072B2", "#D55E00")


def draw_strain_energies(result: Stability, path: Path) -> Path:
    """Strain energy of both disturbances by shear, dilatation and bending (Eq. 24, Table I).

    Raises:
        OSError: if the picture cannot be written.
    """
    from celltrain.diagnostics.energy import perturbation_energy  # JAX

    energies = [perturbation_energy(result.base, shape) for shape in _disturbances(result)]
    figure = Figure(figsize=(6.0, 3.8), dpi=200, layout="constrained")
    axes = figure.add_subplot()
    places = np.arange(len(ENERGY_PARTS) + 1)
    for offset, values, name, color in zip((-0.2, 0.2), energies, NAMES, COLORS, strict=True):
        heights = np.append(values, values.sum())
        axes.bar(places + offset, heights, width=0.38, color=color, label=name)
    largest = max(float(np.abs(each).max()) for each in energies)
    axes.set_yscale("symlog", linthresh=1e-3 * largest)
    axes.axhline(0.0, color="0.3", linewidth=0.8)
    axes.set_xticks(places, [*ENERGY_PARTS, "sum"])
    axes.set_ylabel(r"$W$ of a disturbance ($\mu U r_0^2$)")
    return _finished(figure, path)


def draw_deformation_spectra(result: Stability, path: Path) -> Path:
    """Share of each degree n in both disturbances (E_n of Eq. 16, Fig. 10).

    Raises:
        OSError: if the picture cannot be written.
    """
    figure = Figure(figsize=(5.6, 3.8), dpi=200, layout="constrained")
    axes = figure.add_subplot()
    for shape, name, color in zip(_disturbances(result), NAMES, COLORS, strict=True):
        spectrum = deformation_spectrum(shape)
        axes.semilogy(spectrum / spectrum.sum(), "o-", color=color, markersize=4, label=name)
    axes.set_xlabel("degree $n$")
    axes.set_ylabel(r"$E_n/\sum_n E_n$")
    return _finished(figure, path)


def draw_mode_motions(
    result: Stability, path: Path, *, modes: Sequence[Mode] | None = None
) -> Path:
    """Tumbling and tank-treading of modes (Eqs. 17 to 21), the leading ones unless given.

    Raises:
        OSError: if the picture cannot be written.
    """
    leading = [mode for mode in result.modes if not mode.neutral][:MODES]
    chosen = leading if modes is None else list(modes)
    motions: list[ModeMotion] = [mode_motion(result, mode) for mode in chosen]
    figure = Figure(figsize=(2.4 + 0.8 * len(chosen), 3.8), dpi=200, layout="constrained")
    axes = figure.add_subplot()
    places = np.arange(len(chosen))
    parts = (
        (r"tumbling $|\omega|$", [each.tumbling for each in motions]),
        (r"tank-treading $|\Omega - \omega|$", [each.tank_treading for each in motions]),
    )
    for offset, (name, values), color in zip((-0.2, 0.2), parts, COLORS, strict=True):
        axes.bar(places + offset, values, width=0.38, color=color, label=name)
    names = [
        f"$m$ = {mode.azimuthal_number}\n$j$ = {mode.wave_number}\n{mode.growth_rate:.2g}"
        for mode in chosen
    ]
    axes.set_xticks(places, names, fontsize=8)
    axes.set_xlabel("mode and growth rate ($U/r_0$)")
    axes.set_ylabel("rotation over amplitude ($U/r_0^2$)")
    return _finished(figure, path)


def _disturbances(result: Stability) -> list[Float[np.ndarray, "cell 3 coefficient"]]:
    return [result.shape(result.leading), result.transient_shape()]


def _finished(figure: Figure, path: Path) -> Path:
    axes = figure.axes[0]
    axes.tick_params(direction="in", which="both", right=True)
    axes.legend(fontsize=9, frameon=False)
    figure.savefig(path)
    return path
