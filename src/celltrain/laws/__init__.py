"""The laws of membranes: energies of strain and of bending, as formulas of numbers.

They know nothing of cases, shapes or grids. Their names are those that a case may give, and the
names of their moduli those of the fields of a case's cell.
"""

from celltrain.laws.bending import (
    BENDINGS,
    BalancedMomentBending,
    BendingEnergy,
    BendingLaw,
    ElasticBending,
    HelfrichBending,
    MomentBending,
)
from celltrain.laws.constitutive import LAWS, ConstitutiveLaw, NeoHookean, Skalak

__all__ = [
    "BENDINGS",
    "LAWS",
    "BalancedMomentBending",
    "BendingEnergy",
    "BendingLaw",
    "ConstitutiveLaw",
    "ElasticBending",
    "HelfrichBending",
    "MomentBending",
    "NeoHookean",
    "Skalak",
]
