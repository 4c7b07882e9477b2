"""How the answers at D = 6, packing 0.2 depend on the degree and on each rule."""

from dataclasses import asdict, dataclass

import numpy as np
from page import Page, plain_figure

from celltrain import Base, Stability, Train, stability, steady
from celltrain.stability import NORMS, OrthonormalNorm, numerical_abscissa

DEGREES = (12, 14, 16, 20)
# U_c, alpha and eta (orthonormal, q = 0) of the same equations in a separate trial implementation.
TRIAL = {
    12: (1.7720, 0.01165, 1.741),
    14: (1.7748, 0.0134, 1.78),
    16: (1.7750, 0.0140, 2.03),
    20: (1.7754, 0.01375, 2.22),
}
# The modes that matter have few azimuths; the numerical abscissa's, too.
AZIMUTHAL_NUMBERS = range(4)


@dataclass(frozen=True)
class Answer:
    """The numbers that are compared."""

    base: Base
    result: Stability

    @property
    def cell_velocity(self) -> float:
        """Velocity of the train, U."""
        return self.base.cell_velocity

    @property
    def alpha(self) -> float:
        """Spectral abscissa, U/r0."""
        return self.result.spectral_abscissa

    @property
    def following(self) -> float:
        """The next growth rate that is not the same mode's conjugate."""
        rates = [mode.growth_rate for mode in self.result.modes if not mode.neutral]
        return next(rate for rate in rates[1:] if abs(rate - rates[0]) > 1e-9)

    def eta(self, norm: str) -> float:
        """Numerical abscissa in one of the norms, U/r0."""
        return self.result.numerical_abscissas[norm]

    def uniform_eta(self) -> float:
        """Numerical abscissa of disturbances that are alike in all cells, orthonormal, U/r0."""
        grams = OrthonormalNorm().grams(self.base.coefficients, AZIMUTHAL_NUMBERS)
        return max(
            numerical_abscissa(self.result.blocks[m][0], gram)[0] for m, gram in grams.items()
        )


def answer(train: Train, start: Base | None) -> Answer:
    """The steady train and its dynamics."""
    base = steady(train, start=start)
    result = stability(base, azimuthal_numbers=AZIMUTHAL_NUMBERS, estimate_error=False)
    return Answer(base, result)


def variants(train: Train) -> list[tuple[str, dict[str, float]]]:
    """Every rule of the resolution made finer, one at a time, and all together."""
    rules = train.sizes
    half_more: dict[str, dict[str, float]] = {
        "polar nodes": {
            "polar_radial": 3 * rules.polar_radial // 2,
            "polar_azimuthal": 2 * (3 * rules.polar_azimuthal // 4),
        },
        "target order": {"target_order": 3 * rules.target_order // 2},
        "source order": {"source_order": 3 * rules.source_order // 2},
        "energy order": {"energy_order": 3 * rules.energy_order // 2},
    }
    others: dict[str, dict[str, float]] = {
        "near cutoff, shorter": {"near_cutoff": 0.8 * train.resolution.near_cutoff},
        "near cutoff, longer": {"near_cutoff": 1.4 * train.resolution.near_cutoff},
        "tolerance": {"tolerance": 0.01 * train.resolution.tolerance},
    }
    everything: dict[str, float] = {}
    for change in half_more.values():
        everything |= change
    everything |= others["tolerance"]
    return [*half_more.items(), *others.items(), ("all of them", everything)]


def study() -> None:
    page = Page("convergence", "Convergence with degree and rules")
    page.text(
        f"""
D = 6 r0, packing 0.2, N = 8, viscosity ratio 1; rates in U/r0, azimuthal numbers 0 to
{max(AZIMUTHAL_NUMBERS)}. alpha: spectral abscissa, neutral modes set aside; eta: numerical
abscissa. "Trial" is an earlier, separate implementation of the same equations with other rules;
expected are cell velocities equal to 0.1 %, alpha and eta to 2 %.
"""
    )
    train = Train(diameter=6, packing=0.2, cells=8, degree=12)
    answers: dict[int, Answer] = {}
    start: Base | None = None
    for degree in DEGREES:
        page.log(f"degree {degree}")
        answers[degree] = answer(train.changed(degree=degree), start)
        start = answers[degree].base
    _degrees(page, answers)
    _rules(page, train, answers[train.degree])
    _figure(page, answers)
    page.write()


def _degrees(page: Page, answers: dict[int, Answer]) -> None:
    page.heading("Degree M, default rules")
    rows = []
    for degree, each in answers.items():
        velocity, alpha, _ = TRIAL[degree]
        mode = each.result.leading
        rows.append(
            (
                degree,
                f"{each.cell_velocity:.5f}",
                f"{velocity:.4f}",
                f"{each.alpha:.5f}",
                f"{alpha:g}",
                f"{mode.azimuthal_number}, {mode.wave_number}",
                f"{each.following:.5f}",
                f"{each.base.truncation_error:.1e}",
                f"{each.base.residual:.0e}",
            )
        )
    page.table(
        (
            "M",
            "U_c",
            "trial",
            "alpha",
            "trial",
            "m, j",
            "next",
            "left out by the degree, U",
            "residual, U",
        ),
        rows,
    )
    page.text(
        "The numerical abscissa depends on the norm, and on the degree more than alpha does: it has"
        " not converged at the largest degree here. The trial implementation took disturbances that"
        " are alike in all cells (q = 0); those that grow fastest need not be. m, j: of the"
        " disturbance that grows fastest in the paper's norm."
    )
    names = [norm.name for norm in NORMS]
    page.table(
        ("M", *(f"eta, {name}" for name in names), "m, j", "orthonormal, q = 0", "trial, q = 0"),
        [
            (
                degree,
                *(f"{each.eta(name):.4f}" for name in names),
                f"{each.result.transient.azimuthal_number}, {each.result.transient.wave_number}",
                f"{each.uniform_eta():.4f}",
                f"{TRIAL[degree][2]:g}",
            )
            for degree, each in answers.items()
        ],
    )
    finest = answers[max(answers)]
    page.text(
        "Changes against M = "
        f"{max(answers)}: "
        + "; ".join(
            f"M = {degree}: U_c {_percent(each.cell_velocity, finest.cell_velocity)},"
            f" alpha {_percent(each.alpha, finest.alpha)},"
            f" eta (orthonormal) {_percent(each.eta('orthonormal'), finest.eta('orthonormal'))}"
            for degree, each in answers.items()
            if each is not finest
        )
        + "."
    )


def _percent(value: float, finest: float) -> str:
    return f"{100.0 * (value / finest - 1.0):+.2f} %"


def _rules(page: Page, train: Train, usual: Answer) -> None:
    page.heading(f"Rules, M = {train.degree}")
    page.text(
        "Each rule made finer alone, then together; changes against the default rules. What the"
        " rules leave is well below what the degree leaves out."
    )
    rows = []
    for name, changes in variants(train):
        page.log(name)
        each = answer(train.changed(**changes), usual.base)
        before = train.resolution.model_dump() | asdict(train.sizes)
        rows.append(
            (
                name,
                ", ".join(f"{before[leaf]:g} to {value:g}" for leaf, value in changes.items()),
                f"{each.cell_velocity - usual.cell_velocity:+.1e}",
                f"{each.alpha:.6f}",
                _percent(each.alpha, usual.alpha),
                _percent(each.eta("orthonormal"), usual.eta("orthonormal")),
                f"{each.base.residual:.0e}",
            )
        )
    columns = ("rule", "from, to", "change of U_c", "alpha", "change", "change of eta", "residual")
    page.table(columns, rows)


def _figure(page: Page, answers: dict[int, Answer]) -> None:
    figure = plain_figure(8.0, 3.4)
    left, right = figure.subplots(1, 2)
    degrees = np.array(list(answers))
    left.plot(degrees, [each.alpha for each in answers.values()], "o-", label="celltrain")
    left.plot(degrees, [TRIAL[degree][1] for degree in degrees], "kx", label="trial")
    left.set(xlabel="degree $M$", ylabel=r"$\alpha$, $U/r_0$")
    left.legend()
    for norm in NORMS:
        rates = [each.eta(norm.name) for each in answers.values()]
        right.plot(degrees, rates, "o-", label=f"norm: {norm.name}")
    right.set(xlabel="degree $M$", ylabel=r"$\eta$, $U/r_0$")
    right.legend()
    for axes in (left, right):
        axes.set_xticks(degrees)
    page.figure(figure, "Spectral and numerical abscissa against the degree, D = 6, packing 0.2")
