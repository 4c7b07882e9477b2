"""Distributions of outputs, and from which parameters their variance comes, with their errors.

With f at the points of the matrices A, B and A_i (A with the i-th column of B), V the variance of
f, and <> the mean over points, the first-order index, the part of V that goes when the i-th
parameter is known, and the total one, the part that stays when all others are, are estimated by

    S_i = <f(B) [f(A_i) - f(A)]>/V,    T_i = <[f(A) - f(A_i)]^2>/(2 V)

(Sobol 2001; Saltelli et al. 2010, Table 2 (b) and (f), as in `scipy.stats.sobol_indices`, which
wants numbers of points that failed trains do not leave). They assume nothing of f, so they hold
where another mode takes the lead and f has a kink. Their sum over i is 1 where parameters act
independently.

Errors are those of resampling points with all their trains (Efron & Tibshirani 1993). Sobol's
points are more even than independent ones, so that these errors are rather too large.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

#: Probabilities of the quantiles that are reported.
PROBABILITIES = (0.05, 0.25, 0.5, 0.75, 0.95)
#: Part of the resamples that an interval holds.
CONFIDENCE = 0.95
RESAMPLES = 500
# A variance below this part of the square of the mean is what rounding leaves.
_NO_VARIANCE = 1e-18

Outputs = Float[np.ndarray, "output matrix point"]


@dataclass(frozen=True)
class Summary:
    """Moments and quantiles of each output over all trains that were found, and their errors."""

    mean: Float[np.ndarray, " output"]
    standard_deviation: Float[np.ndarray, " output"]
    quantile: Float[np.ndarray, "output probability"]
    positive: Float[np.ndarray, " output"]


@dataclass(frozen=True)
class Indices:
    """Sobol indices of each output by each parameter; NaN where an output does not vary."""

    first_order: Float[np.ndarray, "output parameter"]
    total_order: Float[np.ndarray, "output parameter"]


def summarise(values: Outputs, found: Bool[np.ndarray, "matrix point"]) -> Summary:
    """Moments, quantiles and the part that is positive; of no train at all NaN."""
    numbers = values[:, found]
    if numbers.shape[1] == 0:
        none = np.full(len(values), np.nan)
        return Summary(none, none, np.full((len(values), len(PROBABILITIES)), np.nan), none)
    count = numbers.shape[1]
    mean = numbers.mean(axis=1)
    variance = ((numbers - mean[:, None]) ** 2).sum(axis=1) / max(1, count - 1)
    return Summary(
        mean,
        np.sqrt(variance),
        np.quantile(numbers, PROBABILITIES, axis=1).T,
        (numbers > 0.0).mean(axis=1),
    )


def sobol_indices(values: Outputs) -> Indices:
    """First-order and total indices from trains of which none is missing.

    **Arguments:** `values`: the matrices A, B and A_i, in this order.
    """
    # Relative to the mean, as rounding would matter otherwise.
    centred = values - values[:, :2].mean(axis=(1, 2), keepdims=True)
    first, second, mixed = centred[:, 0], centred[:, 1], centred[:, 2:]
    variance = centred[:, :2].var(axis=(1, 2))
    scale = np.abs(values[:, :2]).mean(axis=(1, 2)) ** 2
    variance = np.where(variance > _NO_VARIANCE * scale, variance, np.nan)[:, None]
    return Indices(
        (second[:, None] * (mixed - first[:, None])).mean(axis=-1) / variance,
        0.5 * ((first[:, None] - mixed) ** 2).mean(axis=-1) / variance,
    )


@dataclass(frozen=True)
class WithErrors:
    """What is estimated of a sample, the errors of moments, and the intervals of indices.

    `complete` is the number of points of which all trains were found, from which indices come.
    """

    summary: Summary
    error: Summary
    indices: Indices | None
    low: Indices | None
    high: Indices | None
    complete: int


def estimated(values: Outputs, *, indices: bool, seed: int = 0) -> WithErrors:
    """Moments, quantiles and indices with the errors of resampling; NaN are trains not found."""
    found = np.isfinite(values).all(axis=0)
    whole = found.all(axis=0)
    complete = values[:, :, whole]
    generator = np.random.default_rng(seed)
    summaries, others = [], []
    indices = indices and complete.shape[2] > 1
    for _ in range(RESAMPLES):
        picked = generator.integers(found.shape[1], size=found.shape[1])
        summaries.append(summarise(values[:, :, picked], found[:, picked]))
        if indices:
            again = generator.integers(complete.shape[2], size=complete.shape[2])
            others.append(sobol_indices(complete[:, :, again]))
    names = ("mean", "standard_deviation", "quantile", "positive")
    error = Summary(*(np.std([getattr(e, name) for e in summaries], axis=0) for name in names))
    tail = 0.5 * (1.0 - CONFIDENCE)
    low, high = (
        Indices(
            *(
                np.quantile([getattr(each, name) for each in others], part, axis=0)
                for name in ("first_order", "total_order")
            )
        )
        if indices
        else None
        for part in (tail, 1.0 - tail)
    )
    return WithErrors(
        summarise(values, found),
        error,
        sobol_indices(complete) if indices else None,
        low,
        high,
        int(whole.sum()),
    )
