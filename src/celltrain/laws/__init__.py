"""The laws of membranes: energies of strain and of bending, as formulas of numbers.

They know nothing of cases, shapes or grids. Their names are those that a case may give, and the
names of their moduli those of the fields of a case's cell.
"""

from celltrain.laws.bending import BENDINGS, BendingLaw, ElasticBending, HelfrichBending
from celltrain.laws.constitutive import LAWS, ConstitutiveLaw, NeoHookean, Skalak

__all__ = [
    "BENDINGS",
    "LAWS",
    "BendingLaw",
    "ConstitutiveLaw",
    "ElasticBending",
    "HelfrichBending",
    "NeoHookean",
    "Skalak",
]
