"""Growth of a train with the coupling of near neighbours removed (Fig. 20)."""

from collections.abc import Sequence

from matplotlib.figure import Figure

from celltrain.pictures.style import in_style
from celltrain.stability import GrowthWithout


@in_style()
def draw_growth_without_neighbours(trains: dict[str, Sequence[GrowthWithout]]) -> Figure:
    """alpha~ over the number of neighbours removed on each side, a line for each named train.

    The scale is logarithmic beyond a hundredth of the largest growth rate, so that decay shows.
    """
    figure = Figure(figsize=(5.6, 4.0), layout="constrained")
    axes = figure.subplots()
    for name, each in trains.items():
        axes.plot(
            [found.removed for found in each],
            [found.spectral_abscissa for found in each],
            "o-",
            label=name,
        )
    largest = max(abs(found.spectral_abscissa) for each in trains.values() for found in each)
    axes.set_yscale("symlog", linthresh=0.01 * largest)
    axes.axhline(0.0, color="0.6", linewidth=0.8)
    axes.set_xticks(sorted({found.removed for each in trains.values() for found in each}))
    axes.set_xlabel("neighbours removed on each side")
    axes.set_ylabel(r"largest growth rate $\tilde\alpha$ ($U/r_0$)")
    # Curves may pass anywhere, so the names are above.
    figure.legend(loc="outside upper center", ncols=2)
    return figure
