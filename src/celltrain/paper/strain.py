"""Strain energy of disturbances: Table I, and the paper's statements about it (Sec. V G)."""

import numpy as np
import scipy
import xarray as xr
from matplotlib.figure import Figure

from celltrain.membrane import meridian_membrane
from celltrain.paper.curves import side_by_side
from celltrain.paper.finding import Finding, finding
from celltrain.paper.resolutions import LABELS, PAPER, Resolutions, Style, present
from celltrain.paper.trains import CELLS, CORNERS, analysed, dataset
from celltrain.stability import PaperNorm, Stability, normed_blocks, second_variation

#: W_alpha, and W_eta by shear, dilatation and bending, of Table I for `CORNERS`.
TABLE = (
    (1.13e-2, 0.43, 2.01, 0.04),
    (4.29e-3, 0.74, 1.52, 0.16),
    (9.16e-3, 0.59, 1.31, 0.05),
    (3.95e-3, 0.43, 4.25, 0.23),
)
#: The paper's smallest W of a disturbance that grows at first, and the largest share of W_alpha.
LEAST, SMALL = 0.6, 0.05
#: From mean energies in mu U r0^2 to the sum over the cells in mu U* r0^2, U* = U/10.
TO_TABLE = 10.0 * CELLS
#: The amplitude eps at which the paper computes energies, r0.
PAPER_AMPLITUDE = 1e-3
#: Within what factor energies may be called the printed ones.
AGREE = 1.5
PARTS = ("shear", "dilatation", "bending")


def compute(degree: int | None) -> xr.Dataset:
    """W of Eq. (24) by part, as in the table, of both disturbances; least W of what grows."""
    from celltrain.diagnostics import perturbation_energy  # JAX

    found = np.full((len(CORNERS), 2, len(PARTS)), np.nan)
    least = np.full(len(CORNERS), np.nan)
    for row, (diameter, packing) in enumerate(CORNERS):
        result = analysed(degree, numbers=None, diameter=diameter, packing=packing)
        least[row] = least_energy(result)
        for column, shape in enumerate((result.shape(result.leading), result.transient_shape())):
            found[row, column] = TO_TABLE * perturbation_energy(result.base, shape)
    return dataset(
        {
            "energy": (
                ("train", "disturbance", "part"),
                found,
                "mu U* r0^2",
                "strain energy of a disturbance, eps = 1e-3, summed over the cells (Eq. 24)",
            ),
            "least": (
                ("train",),
                least,
                "mu U* r0^2",
                "least strain energy of all that grows at first, the same in all cells and"
                " axisymmetric left out",
            ),
            "printed": (
                ("train", "column"),
                np.array(TABLE),
                "",
                "as printed in Table I",
            ),
        },
        {
            "disturbance": ["v_alpha", "v_eta"],
            "part": list(PARTS),
            "column": ["W_alpha", *(f"W_eta, {part}" for part in PARTS)],
            "diameter": ("train", [each[0] for each in CORNERS], {"units": "r0"}),
            "packing": ("train", [each[1] for each in CORNERS]),
        },
        "strain energy of the leading mode and of what grows fastest at first",
    )


def least_energy(result: Stability) -> float:
    """Least W, as in the table, of all disturbances that grow at first, to second order.

    Those are the eigenvectors d of (G A + A^H G)/2 with positive eigenvalues, G of Eq. (8); with H
    the second variation of the energy, W = eps d^H H d/(2 N d^H G d) on average over the cells.
    What is axisymmetric and alike in all cells has an energy of first order, and is left out.
    """
    membrane, shape = meridian_membrane(result.base.train), result.base.coefficients
    stiffness = second_variation(membrane, shape, result.azimuthal_numbers)
    least = np.inf
    for (m, wave), block in normed_blocks(result, PaperNorm()).items():
        if m == 0 and wave == 0:
            continue
        rates, vectors = scipy.linalg.eigh(0.5 * (block.matrix + block.matrix.conj().T))
        growing = block.lift @ vectors[:, rates > 0.0]
        energies = np.einsum("ug,uv,vg->g", growing.conj(), stiffness[m], growing).real
        # Coordinates of unit norm: d^H G d = 1.
        least = min(least, *energies) if energies.size else least
    return float(TO_TABLE * PAPER_AMPLITUDE * least / (2.0 * result.base.train.cells))


def draw(data: Resolutions) -> Figure:
    """Table I as a picture: energies beside the printed ones."""
    figure, panels = side_by_side(2)
    places = np.arange(len(CORNERS))
    names = [f"{diameter:g}, {packing:g}" for diameter, packing in CORNERS]
    for axes, disturbance in zip(panels, ("v_alpha", "v_eta"), strict=True):
        printed = np.array(TABLE)
        parts = printed[:, :1] if disturbance == "v_alpha" else printed[:, 1:]
        axes.plot(places, parts.sum(axis=1), "k_", ms=22, mew=1.5, label="printed")
        for name, each in present(data):
            energy = each["energy"].sel(disturbance=disturbance)
            total = energy.sum("part").values
            style: Style = {"mfc": "none", "marker": "o"} if name == PAPER else {"marker": "D"}
            axes.plot(places, np.abs(total), ls="none", ms=6, label=LABELS[name], **style)
        axes.set_xticks(places, names)
        axes.set(xlabel=r"$D/r_0$, $\phi$", yscale="log", xlim=(-0.5, len(places) - 0.5))
        axes.set_ylabel(rf"$W_\{disturbance[2:]}$ ($\mu U^* r_0^2$)")
    panels[0].legend(fontsize=8, frameon=False)
    return figure


def findings(data: xr.Dataset) -> list[Finding]:
    """The statements about strain energies (Table I)."""
    energy = data["energy"]
    slow, fast = (energy.sel(disturbance=name) for name in ("v_alpha", "v_eta"))
    printed = np.array(TABLE)
    ratios = {
        "W_alpha": np.abs(slow.sum("part").values) / printed[:, 0],
        "W_eta": fast.sum("part").values / printed[:, 1:].sum(axis=1),
    }
    ordered = fast.sel(part=["bending", "shear", "dilatation"])
    return [
        *(
            finding(
                "P30",
                f"{name} as printed for four trains",
                "ours over the printed: " + ", ".join(f"{each:.2f}" for each in values),
                bool(((values < AGREE) & (values > 1.0 / AGREE)).all()),
                values,
            )
            for name, values in ratios.items()
        ),
        finding(
            "P31",
            "W_alpha is small beside W_eta",
            f"at most {float((abs(slow.sum('part')) / fast.sum('part')).max()):.1%} of it",
            bool((abs(slow.sum("part")) < SMALL * fast.sum("part")).all()),
            energy,
        ),
        finding(
            "P31",
            f"everything that grows at first has W > {LEAST:g}",
            "least "
            + ", ".join(f"{float(each):.2g}" for each in data["least"])
            + "; of what grows fastest "
            + ", ".join(f"{float(each):.2g}" for each in fast.sum("part")),
            float(data["least"].min()) > LEAST,
            data["least"],
        ),
        finding(
            "P31",
            "of W_eta dilatation is the largest part, bending the smallest",
            "; ".join(", ".join(f"{float(each):.2g}" for each in train) for train in fast.values),
            bool((np.diff(ordered.values, axis=-1) > 0.0).all()),
            energy,
        ),
    ]
