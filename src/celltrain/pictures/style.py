"""What all pictures share: colours that colour-blind readers tell apart, and the case in words."""

from celltrain.parameters import Train

# The palette of Okabe & Ito.
BLUE, VERMILION, GREEN, PURPLE = "#0072B2", "#D55E00", "#009E73", "#CC79A7"
ORANGE, SKY = "#E69F00", "#56B4E9"
#: The first for m = 0, or what there is several of.
COLORS = (BLUE, VERMILION, GREEN, PURPLE)
#: Letters and lines that are no data; data in the background.
INK, GREY = "0.15", "0.6"


def case_title(train: Train) -> str:
    """What a picture says of its case."""
    return (
        f"$D$ = {train.tube.diameter:g} $r_0$, $\\phi$ = {train.packing:g}, $N$ = {train.cells}, "
        f"viscosity ratio {train.flow.viscosity_ratio:g}"
    )
