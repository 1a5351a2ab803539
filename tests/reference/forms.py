"""Which independent computation gives the periods, actions and turning points of which entry."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from mpmath import mpf

from tests.reference.closed_forms import FORMS, Values
from tests.reference.quadratures import one_at_a_time, staeckel

THOROUGH = frozenset(FORMS)
"""Entries with closed forms; they also get states at more times."""
COUPLED = frozenset({
    "calogero-moser", "charge-in-monopole-field", "free-particle-spherical", "garnier", "henon-heiles-kdv",
    "kepler-prolate", "kerr", "kuzmin-kutuzov", "liouville-three", "neumann", "perfect-oblate-spheroid",
    "schwarzschild", "stark", "triaxial-geodesics", "two-centres-plane", "two-centres-space", "vinti",
})  # fmt: skip
"""Several essential coordinates that share the separation constants."""

Form = Callable[[Mapping[str, mpf], Mapping[str, mpf], Mapping[str, mpf]], Values]


def form(entry: str) -> Form:
    """The closed form of an entry, or tanh-sinh quadratures."""
    if entry in FORMS:
        return FORMS[entry]
    return staeckel(entry) if entry in COUPLED else one_at_a_time(entry)
