"""Everything that celltrain computes, one analysis in a file (see `celltrain.contract`)."""
