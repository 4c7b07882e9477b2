"""Do the two operators agree on the dynamics of a train?

Whole blocks, computed on the meridian and by automatic differentiation of the operator in three
dimensions, which share the laws of the membrane and nothing of the flow.
"""

import json
import time
from dataclasses import replace

import jax.numpy as jnp
import numpy as np
from page import FOLDER, Page

from celltrain import Base, Train, steady
from celltrain.harmonics import azimuthal_basis, coefficients_of
from celltrain.membrane import place_cells
from celltrain.meridian.rules import Rules, choose_rules
from celltrain.stability import linear_blocks
from celltrain.steady.problem import SteadyProblem
from celltrain.train.full_matrix import ExactDerivative, matrix_operator

CELLS, DEGREE = 2, 6
NUMBERS = range(4)
PHASES = np.pi * np.arange(CELLS)
#: Rules in three dimensions. An odd order: the even ones are odd grids seen from the poles.
FINE = {"source_order": 39, "polar_radial": 64, "polar_azimuthal": 72, "tolerance": 1e-9}
#: In a narrow tube, where each of these costs many times more.
NARROW_FINE = {"source_order": 31, "polar_radial": 56, "polar_azimuthal": 64, "tolerance": 1e-9}
#: On the meridian: tolerance, and nodes of the polar rule along the radius and around.
MERIDIAN = {"tolerance": 1e-10, "radial": 90, "around": 100}
EXPECTED = 1e-7
# From a train that is steady by the usual rules to one that is by these.
NEWTON_STEPS = 3
# What is known already is not computed again: each case takes minutes.
FILE = FOLDER / "data" / "agreement.json"
# Directions at once: each takes about 2 GiB.
BATCH = 2
CASES: tuple[dict[str, object], ...] = (
    {"diameter": 6, "packing": 0.2},
    {"diameter": 6, "packing": 0.5},
    {"diameter": 6, "packing": 0.7},
    {"diameter": 6, "packing": 0.2, "viscosity_ratio": 5.0},
    {"diameter": 6, "packing": 0.5, "viscosity_ratio": 5.0},
    {"diameter": 6, "packing": 0.5, "law": "neo_hookean", "bending": "elastic"},
    {"diameter": 6, "packing": 0.5, "law": "skalak", "bending": "helfrich"},
    {"diameter": 6, "packing": 0.5, "law": "neo_hookean", "bending": "helfrich"},
)
NARROW: dict[str, object] = {"diameter": 3, "packing": 0.2}


def differences(case: dict[str, object]) -> np.ndarray:
    """Norm of the difference over that of the largest block, for each wave and m.

    Only along the members of these azimuthal numbers: others tell nothing about their blocks.
    """
    train = Train(**case, cells=CELLS, degree=DEGREE, **FINE)  # type: ignore[arg-type]
    base, rules = _finely(train)
    size = base.coefficients.size
    members = {m: azimuthal_basis(DEGREE, m) for m in NUMBERS}
    columns = np.asarray(
        ExactDerivative().columns(
            matrix_operator(base),
            jnp.asarray(place_cells(base.coefficients, train, CELLS)),
            jnp.asarray(np.concatenate(list(members.values()))),
            BATCH,
        )
    ).reshape(-1, CELLS, size)
    blocks = linear_blocks(base, PHASES, NUMBERS, rules=rules)
    norm = max(np.linalg.norm(blocks[m][w], 2) for m in NUMBERS for w in range(CELLS))
    result = np.empty((CELLS, len(NUMBERS)))
    # What cell p does to the first is what the first does to the one p places back.
    back = -np.arange(CELLS) % CELLS
    for wave, q in enumerate(PHASES):
        full = np.einsum("dps,p->sd", columns[:, back], np.exp(1j * q * np.arange(CELLS)))
        first = 0
        for m in NUMBERS:
            last = first + len(members[m])
            apart = full[:, first:last] - members[m].reshape(-1, size).T @ blocks[m][wave]
            result[wave, m] = np.linalg.norm(apart, 2) / norm
            first = last
    return result


def difference_along(case: dict[str, object]) -> np.ndarray:
    """The same along one random direction for each m, in a narrow tube, one cell, q = 0.

    There the sums over near points are so long that whole blocks would take hours.
    """
    train = Train(**case, cells=1, degree=DEGREE, **NARROW_FINE)  # type: ignore[arg-type]
    base, rules = _finely(train)
    random, size = np.random.default_rng(1), base.coefficients.size
    blocks = linear_blocks(base, [0.0], NUMBERS, rules=rules)
    norm = max(np.linalg.norm(each[0], 2) for each in blocks.values())
    directions, wanted = [], []
    for m in NUMBERS:
        members = azimuthal_basis(DEGREE, m)
        parts = random.normal(size=len(members))
        parts /= np.linalg.norm(parts)
        directions.append(np.tensordot(parts, members, 1))
        wanted.append(members.reshape(-1, size).T @ (blocks[m][0].real @ parts))
    columns = ExactDerivative().columns(
        matrix_operator(base),
        jnp.asarray(place_cells(base.coefficients, train, 1)),
        jnp.asarray(np.stack(directions)),
        1,
    )
    apart = np.asarray(columns).reshape(-1, size) - np.stack(wanted)
    return np.linalg.norm(apart, axis=1)[None] / norm


def _finely(train: Train) -> tuple[Base, Rules]:
    """A train that is steady by fine rules, and these."""
    base = steady(train, estimate_error=False)
    rules = choose_rules(
        base.profile,
        period=train.period,
        radius=train.radius,
        targets=train.sizes.target_order,
        **MERIDIAN,  # type: ignore[arg-type]
    )
    return _steady_by(base, rules), rules


def _steady_by(base: Base, rules: Rules) -> Base:
    """The train that is steady by these rules: by the usual ones it moves at 1e-6 U there.

    Where cells do not move rigidly the viscosity ratio matters also for the train itself.
    """
    problem, profile = SteadyProblem(base.train), base.profile
    for _ in range(NEWTON_STEPS):
        state = problem.state(profile, rules)
        profile = problem.moved(profile, state.step(np.inf))
    return replace(base, coefficients=coefficients_of(profile))


def study() -> None:
    page = Page("agreement", "Two operators, one dynamics")
    page.text(
        f"""
The linear dynamics of a train stands on the meridian; simulations stand on an operator for cells
of any shape in three dimensions. Here the second computes the first's blocks: automatic
differentiation along each disturbance of one cell with m = 0 to {max(NUMBERS)}, N = {CELLS},
M = {DEGREE}, rules far finer than usual on both sides (source order {FINE["source_order"]}, polar
rule {FINE["polar_radial"]} x {FINE["polar_azimuthal"]}, tolerance {FINE["tolerance"]:g}; on the
meridian {MERIDIAN["radial"]} x {MERIDIAN["around"]}, {MERIDIAN["tolerance"]:g}). Given is the
2-norm of the difference of the blocks, largest over q = 0 and pi, relative to that of the
largest block. At D = 3 these rules do not end within ten minutes of a processor, with eleven
gigabytes; there it is the norm of the difference along one random direction for each m, N = 1, q =
0, source order {NARROW_FINE["source_order"]}, polar rule {NARROW_FINE["polar_radial"]} x
{NARROW_FINE["polar_azimuthal"]}. Expected: at most {EXPECTED:g}.
"""
    )
    rows, worst = [], 0.0
    known = json.loads(FILE.read_text()) if FILE.exists() else {}
    for case in (*CASES, NARROW):
        begun, name = time.perf_counter(), json.dumps(case)
        if name not in known:
            compute = difference_along if case is NARROW else differences
            known[name] = compute(case).tolist()
            FILE.write_text(json.dumps(known, indent=1) + "\n")
        found = np.max(known[name], axis=0)
        worst = max(worst, float(found.max()))
        words = [f"D = {case['diameter']}, packing {case['packing']}"]
        words += [f"viscosity ratio {case.get('viscosity_ratio', 1.0):g}"]
        words += [f"{case.get('law', 'skalak')}, {case.get('bending', 'elastic')} bending"]
        rows.append((", ".join(words).replace("_", "-"), *(f"{each:.1e}" for each in found)))
        page.log(f"{rows[-1]}, {time.perf_counter() - begun:.0f} s")
    page.table(("train", *(f"m = {m}" for m in NUMBERS)), rows)
    page.text(f"Largest: {worst:.1e}. Below {EXPECTED:g}: {'yes' if worst <= EXPECTED else 'NO'}.")
    page.text(
        f"What is in `{FILE.relative_to(FOLDER)}` is not computed again; all of it takes a quarter"
        " of an hour."
    )
    page.write()
