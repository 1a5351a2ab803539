"""Angles in the turn that a closed form is of."""

from __future__ import annotations

import mpmath
import sympy as sp

from hjsolve.closed_form.evaluation import many_digits
from hjsolve.closed_form.forms import RegimeForms
from hjsolve.closed_form.regions import middle_of
from hjsolve.closed_form.sampling import Sample


def in_the_turn(form: RegimeForms, name: str, sample: Sample) -> sp.Expr:
    """The place, an angle in the turn that the form is of: a libration about π is that from 0 to 2π."""
    place = sample.places[name]
    for curve, _ in form.regime.regions:
        if curve.coordinate.name == name and curve.substitution.closed:
            middle = middle_of(curve, many_digits(sample.values, 60))
            turns = mpmath.nint((middle - float(place)) / (2 * mpmath.pi))
            return place + sp.Rational(str(mpmath.nstr(2 * mpmath.pi * turns, 30)))
    return place
