"""Ways to march a train in time: methods, their settings, and what each remembers."""

from typing import TypeAlias

from celltrain.evolution.methods.euler import EulerMemory, ForwardEuler
from celltrain.evolution.methods.integrator import Integrator, Manner, Step, Work
from celltrain.evolution.methods.runge_kutta_chebyshev import ChebyshevMemory, RungeKuttaChebyshev

#: What a method may remember.
Memory: TypeAlias = ChebyshevMemory | EulerMemory

#: What there is to march with.
Method: TypeAlias = RungeKuttaChebyshev | ForwardEuler

__all__ = [
    "ChebyshevMemory",
    "EulerMemory",
    "ForwardEuler",
    "Integrator",
    "Manner",
    "Memory",
    "Method",
    "RungeKuttaChebyshev",
    "Step",
    "Work",
]
