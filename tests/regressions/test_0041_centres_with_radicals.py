"""Two centres of force at irrational places: denesting √(3 + √7/…) went round in circles, sympy found no normal form."""

import pytest
import sympy as sp

import hjsolve
from hjsolve.algebra.reader import Reader

pytestmark = pytest.mark.rotating_file(2)


def two_centres(first, second):
    terms = (" + ".join(f"({q} - ({c}))**2" for q, c in zip("xyz", centre, strict=False)) for centre in (first, second))
    names = "xyz"[: len(first)]
    kinetic = " + ".join(f"dot({q})**2/2" for q in names)
    return hjsolve.System(dict.fromkeys(names, "line"), kinetic, " - ".join(["0", *(f"1/sqrt({t})" for t in terms)]))


@pytest.mark.nightly_cases("first0-second0")
@pytest.mark.parametrize(
    ("first", "second"),
    [
        (("1/3", "1/7"), ("-sqrt(2)", "1/5")),
        (("(1 + sqrt(5))/2", "0"), ("0", "1")),
        pytest.param(*(("sqrt(2)", "sqrt(3)/5"), ("-sqrt(2)", "1")), marks=pytest.mark.nightly),
        (("sqrt(2 + sqrt(2))", "0"), ("0", "1")),
        (("2**(1/3)", "0"), ("0", "pi")),
        (("sqrt(2)", "0", "1"), ("0", "1", "0")),
    ],
)
def test_the_foci_of_the_web_are_the_centres(first, second):
    found = hjsolve.find_coordinates(two_centres(first, second))
    (web,) = found.webs
    assert web.certified
    assert found.complete
    centres = {tuple(sp.N(sp.sympify(c), 30) for c in centre) for centre in (first, second)}
    n = len(first)
    # mu = 0, nu = 0 and pi are the two ends of the segment between the foci
    for nu in (0, sp.pi):
        place = [web.transformation[q].subs({s: 0 for s in web.system.symbols.values() if s.name in ("mu", "phi")})
                 for q in "xyz"[:n]]  # fmt: skip
        place = [x.subs(dict.fromkeys(x.free_symbols, nu)) for x in place]
        assert any(all(abs(sp.N(a - b, 30)) < 1e-25 for a, b in zip(place, c, strict=True)) for c in centres)


@pytest.mark.parametrize("text", ["sqrt(3 + sqrt(2))", "sqrt(5 + 3*sqrt(3 + sqrt(7)))", "x*sqrt(x**2 + 3 + sqrt(2))"])
def test_denesting_ends_where_it_does_not_make_roots_less_nested(text):
    x = sp.sympify(text, {"x": sp.Symbol("x", real=True)})
    reader = Reader([x])
    square = reader.element(x) ** 2 - reader.element(sp.expand(x**2))
    assert square.is_zero


@pytest.mark.parametrize("text", ["sqrt(5 + 2*sqrt(6)) - sqrt(2) - sqrt(3)", "sqrt(6 + 4*sqrt(2)) - 2 - sqrt(2)"])
def test_what_can_be_denested_still_is(text):
    assert Reader().element(sp.sympify(text)).is_zero
