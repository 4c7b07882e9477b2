"""Loops compiled by Numba that XLA calls: sums over pairs, which XLA's own code does slowly."""

from celltrain.compiled.near_loops import FORCE_PAIRS, NODE_FORCES, STRESSLET_PAIRS

__all__ = ["FORCE_PAIRS", "NODE_FORCES", "STRESSLET_PAIRS"]
