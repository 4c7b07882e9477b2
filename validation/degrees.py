"""The degrees at which pages compute."""

from celltrain.steady.degree import DEGREES

#: The paper's degree.
PAPER = 12
#: The degree at which growth rates of most trains are known to much better than 1 %.
FINE = 24
#: Those at which convergence is shown.
LADDER = tuple(each for each in DEGREES if each <= 48)
