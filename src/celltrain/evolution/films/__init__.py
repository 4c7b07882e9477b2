"""Thin films: the repulsion of membranes in them, and its forces."""

from celltrain.evolution.films.forces import FilmForces, Films, film_forces
from celltrain.evolution.films.repulsion import Repulsion

__all__ = ["FilmForces", "Films", "Repulsion", "film_forces"]
