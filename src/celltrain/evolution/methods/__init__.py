"""Ways to march a train in time: methods, their settings, and what each remembers."""

from typing import TypeAlias

from celltrain.evolution.methods.euler import EulerMemory, ForwardEuler
from celltrain.evolution.methods.integrator import Integrator, Manner, Step, Work
from celltrain.evolution.methods.runge_kutta_chebyshev import ChebyshevMemory, RungeKuttaChebyshev

#: What a method may remember.
Memory: TypeAlias = ChebyshevMemory | EulerMemory

#: The methods by name.
METHODS: dict[str, type[RungeKuttaChebyshev] | type[ForwardEuler]] = {
    method.__name__: method for method in (RungeKuttaChebyshev, ForwardEuler)
}

__all__ = [
    "METHODS",
    "ChebyshevMemory",
    "EulerMemory",
    "ForwardEuler",
    "Integrator",
    "Manner",
    "Memory",
    "RungeKuttaChebyshev",
    "Step",
    "Work",
]
