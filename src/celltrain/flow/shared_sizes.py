"""Sizes of arrays that many tubes have in common.

Compiled programs belong to the sizes of their arrays. Were the numbers of modes of every tube just
those that it needs, each diameter and packing of a study would compile its own programs, which
takes longer than to run them.
"""

SMALL = (1, 2, 4, 7, 10, 13)
# Times powers of two.
LARGE = (16, 20, 26)


def shared_size(count: int) -> int:
    """The next of 1, 2, 4, 7, 10, 13, 16, 20, 26, 32, 40, 52, ... that is at least `count`."""
    octave = 1
    while count > 2 * LARGE[0] * octave:
        octave *= 2
    larger = (octave * size for size in (*LARGE, 2 * LARGE[0]))
    return next(size for size in (*SMALL, *larger) if size >= count)
