"""Random Stäckel systems, and neighbours that miss separability by one small term.

The construction is Stäckel's theorem read backwards: any nonsingular Φ with row i a function of q_i, and any ψ, give
cᵀ = first row of Φ⁻¹ and V = cᵀψ, and that system separates. Nothing of hjsolve.separation is used here.
"""

from __future__ import annotations

import random
from dataclasses import dataclass

import sympy as sp

from hjsolve.mechanics.system import System

NAMES = ("x", "y", "z", "w")
SMALL = sp.Rational(1, 10**9)


@dataclass(frozen=True)
class Case:
    """A random system and what is known about it."""

    seed: int
    system: System
    separable: bool


def univariate(q: sp.Symbol, generator: random.Random) -> sp.Expr:
    """A random polynomial, trigonometric, exponential or radical function of one coordinate."""
    a, b = generator.randint(1, 5), generator.randint(1, 4)
    forms = (
        lambda: a * q**b + generator.randint(-3, 3),
        lambda: sp.sin(q) ** 2 * a + b,
        lambda: a * sp.cos(q) + b + 5,
        lambda: sp.exp(q) + a,
        lambda: sp.exp(-b * q) * a,
        lambda: sp.cosh(q) ** 2 * a - sp.Rational(b, 2),
        lambda: sp.sqrt(q**2 + a),
        lambda: 1 / (q**2 + a),
        lambda: sp.Integer(a),
        lambda: a * q / (q**2 + b) + 1,
        lambda: sp.log(q**2 + a + 1),
    )
    return forms[generator.randrange(len(forms))]()


def case(seed: int, n: int, *, separable: bool) -> Case | None:
    """A random case; None when the random Φ is singular or a metric coefficient vanishes."""
    generator = random.Random(seed)
    q = [sp.Symbol(name, real=True) for name in NAMES[:n]]
    matrix = sp.Matrix(
        n, n, lambda i, j: univariate(q[i], generator) if generator.random() < 0.8 else generator.randint(0, 2)
    )
    determinant = matrix.det(method="berkowitz")
    cofactors = [matrix.cofactor(i, 0) for i in range(n)]
    here = {s: sp.Rational(k + 2, 7) for k, s in enumerate(q)}
    if any(abs(x.subs(here).evalf(30)) < 1e-12 for x in (determinant, *cofactors)):
        return None
    inverse_metric = [c / determinant for c in cofactors]
    potential = sp.Add(*(c * univariate(s, generator) for c, s in zip(inverse_metric, q)))
    if not separable:
        i, j = generator.sample(range(n), 2)
        disturbance = SMALL * generator.choice((q[i] * q[j], sp.sin(q[i] + q[j]), sp.exp(q[i]) * q[j] ** 2))
        if generator.random() < 0.5:
            potential += disturbance
        else:
            inverse_metric[i] += disturbance
    kinetic = sp.Add(*(sp.Symbol(f"dot({s.name})") ** 2 / (2 * c) for s, c in zip(q, inverse_metric)))
    system = System(dict.fromkeys(NAMES[:n], "line"), kinetic, potential, signature="indefinite")
    return Case(seed, system, separable)
