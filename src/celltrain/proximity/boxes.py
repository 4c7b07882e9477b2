"""Which cells can be within a distance of each other: those whose bounding boxes are."""

import math
from collections.abc import Iterator

import numpy as np
from jaxtyping import Float


def image_shift(image: int, period: float) -> Float[np.ndarray, "3"]:
    """By what the image of a number is displaced, in r0; the cell itself, 0, by nothing."""
    return np.array([0.0, 0.0, image * period if image else 0.0])


def close_boxes(
    points: Float[np.ndarray, "cell point 3"], *, within: float, period: float, images: int = 1
) -> Iterator[tuple[int, int, int]]:
    """Pairs of cells, and the image of the second, whose points' boxes are within a distance.

    Each pair comes once: the first number is not above the second, and a cell meets its own images
    ahead only.

    **Arguments:** `within`: the distance, in r0, along each axis; `period`: by which the image
    p = -images ... images of a cell is displaced along z p times; infinite: there are no images.
    """
    images = images if math.isfinite(period) else 0
    low, high = points.min(axis=1), points.max(axis=1)
    for first in range(len(points)):
        for second in range(first, len(points)):
            for image in range(1 if first == second else -images, images + 1):
                shift = image_shift(image, period)
                below, above = low[second] + shift - within, high[second] + shift + within
                if (low[first] <= above).all() and (high[first] >= below).all():
                    yield first, second, image
