"""What is done with each case of a study: its steady train, and the stability of that."""

from dataclasses import dataclass
from typing import Any, Protocol

from celltrain.diagnostics import mode_motion
from celltrain.parameters import CaseError, Train
from celltrain.stability import Stability, stability
from celltrain.steady import Base, NotConverged
from celltrain.study.definition import Computed


@dataclass(frozen=True)
class Outcome:
    """What comes of a case: the steady train, to go on from, and numbers.

    `values` are by their names among `STUDY_QUANTITIES`.
    """

    base: Base
    values: dict[str, float]


class Computation(Protocol):
    """What is computed of a case; it travels to the workers."""

    @property
    def settings(self) -> dict[str, Any]:
        """What is computed, in what JSON can hold; other settings make other results."""

    def __call__(self, train: Train, start: Base | None) -> Outcome:
        """Compute a case, perhaps from another one's steady train.

        Any exception is the case's failure, its message the reason.
        """


@dataclass(frozen=True)
class StabilityOfCase:
    """The steady train and its linear stability; the degree rises where a case has none."""

    computed: Computed

    @property
    def settings(self) -> dict[str, Any]:
        """See `Computation`."""
        return self.computed.model_dump()

    def __call__(self, train: Train, start: Base | None) -> Outcome:
        """See `Computation`.

        **Raises:** `NotConverged` or `CaseError` if no steady train was found.
        """
        result = self._stability(train, start)
        return Outcome(result.base, values_of(result))

    def _stability(self, train: Train, start: Base | None) -> Stability:
        """From where the study says, or else from the other place."""
        first, second = (None, start) if self.computed.start == "rest" else (start, None)
        estimate = self.computed.estimate_error
        try:
            return stability(train, start=first, estimate_error=estimate)
        except (NotConverged, CaseError):
            if start is None:
                raise
            return stability(train, start=second, estimate_error=estimate)


def values_of(result: Stability) -> dict[str, float]:
    """The numbers of a result that maps are made of, by their names among `STUDY_QUANTITIES`."""
    base, leading, transient = result.base, result.leading, result.transient
    turning = mode_motion(result, leading)
    # What a march of the axisymmetric train alone would reach has none that grow.
    axisymmetric = (
        mode.growth_rate
        for mode in result.modes
        if mode.azimuthal_number == 0 and mode.wave_number == 0 and not mode.neutral
    )
    return {
        "cell_velocity": base.cell_velocity,
        "gap": base.gap,
        "largest_radius": base.largest_radius,
        "effective_viscosity": base.effective_viscosity,
        "residual": base.residual,
        "truncation_error": base.truncation_error,
        "velocity_error": base.velocity_error,
        "spectral_abscissa": result.spectral_abscissa,
        "error_estimate": result.error_estimate,
        "taken_degree": float(base.train.degree),
        "leading_azimuthal_number": float(leading.azimuthal_number),
        "leading_wave_number": float(leading.wave_number),
        "leading_frequency": leading.frequency,
        "tumbling": turning.tumbling,
        "tank_treading": turning.tank_treading,
        "axisymmetric_growth_rate": max(axisymmetric),
        "numerical_abscissa": result.numerical_abscissa,
        "transient_azimuthal_number": float(transient.azimuthal_number),
        "transient_wave_number": float(transient.wave_number),
        "case_seconds": result.seconds["total"],
    }
