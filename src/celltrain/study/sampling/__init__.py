"""Samples: trains whose parameters are drawn from distributions, and what varies with them."""
