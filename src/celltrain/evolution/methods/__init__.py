"""Ways to march a train in time: methods, their settings, and what each remembers."""

from typing import TypeAlias

from celltrain.evolution.methods.automatic import Automatic, AutomaticMemory
from celltrain.evolution.methods.euler import EulerMemory, ForwardEuler
from celltrain.evolution.methods.exponential import ExponentialAdams, ExponentialMemory
from celltrain.evolution.methods.integrator import Integrator, Manner, Step, Work
from celltrain.evolution.methods.runge_kutta_chebyshev import ChebyshevMemory, RungeKuttaChebyshev

#: What a method may remember.
Memory: TypeAlias = AutomaticMemory | ExponentialMemory | ChebyshevMemory | EulerMemory

#: What there is to march with.
Method: TypeAlias = Automatic | ExponentialAdams | RungeKuttaChebyshev | ForwardEuler

__all__ = [
    "Automatic",
    "AutomaticMemory",
    "ChebyshevMemory",
    "EulerMemory",
    "ExponentialAdams",
    "ExponentialMemory",
    "ForwardEuler",
    "Integrator",
    "Manner",
    "Memory",
    "Method",
    "RungeKuttaChebyshev",
    "Step",
    "Work",
]
