"""The degrees at which pages compute."""

#: The paper's degree.
PAPER = 12
#: The degree at which growth rates of most trains are known to much better than 1 %.
FINE = 24
