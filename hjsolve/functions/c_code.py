"""The functions in C, for programs that have no library of elliptic integrals.

Standard C99, double precision, no state. Duplication (Carlson, Numer. Algorithms 10 (1995) 13) and descending means
(DLMF 22.20(ii)), as in ``hjsolve.arithmetic.carlson``.
"""

from __future__ import annotations

import sympy as sp

from hjsolve.errors import InvalidInputError
from hjsolve.functions.printing import Printable

_RF = """
static double carlson_rf(double x, double y, double z) {
    double A = (x + y + z) / 3, X, Y, Z, E2, E3;
    double bound = fmax(fmax(fabs(A - x), fabs(A - y)), fabs(A - z)) * 340.0;
    for (int i = 0; i < 60 && bound > A; i++) {
        double l = sqrt(x) * sqrt(y) + sqrt(x) * sqrt(z) + sqrt(y) * sqrt(z);
        x = (x + l) / 4; y = (y + l) / 4; z = (z + l) / 4; A = (A + l) / 4; bound /= 4;
    }
    X = (A - x) / A; Y = (A - y) / A; Z = -X - Y; E2 = X * Y - Z * Z; E3 = X * Y * Z;
    return (1 + E2 * (E2 / 24 - 0.1 - 3 * E3 / 44) + E3 / 14) / sqrt(A);
}
"""
_RC = """
static double carlson_rc(double x, double y) {
    double factor = 1, root;
    if (y < 0) { factor = sqrt(x / (x - y)); x -= y; y = -y; }
    root = sqrt(fabs(x - y));
    if (x == y) return factor / sqrt(x);
    return factor * (x < y ? atan2(root, sqrt(x)) : asinh(root / sqrt(y))) / root;
}
"""
_RJ_POSITIVE = """
static double carlson_rj_positive(double x, double y, double z, double p) {
    double A = (x + y + z + 2 * p) / 5, total = 0, weight = 1, X, Y, Z, P, E2, E3, E4, E5;
    double bound = fmax(fmax(fabs(A - x), fabs(A - y)), fmax(fabs(A - z), fabs(A - p))) * 512.0;
    for (int i = 0; i < 60 && bound > A; i++) {
        double sx = sqrt(x), sy = sqrt(y), sz = sqrt(z), sp = sqrt(p), l = sx * sy + sx * sz + sy * sz;
        double a = p * (sx + sy + sz) + sx * sy * sz, b = sp * (p + l);
        total += weight * carlson_rc(a * a, b * b);
        weight /= 4;
        x = (x + l) / 4; y = (y + l) / 4; z = (z + l) / 4; p = (p + l) / 4; A = (A + l) / 4; bound /= 4;
    }
    X = (A - x) / A; Y = (A - y) / A; Z = (A - z) / A; P = -(X + Y + Z) / 2;
    E2 = X * Y + X * Z + Y * Z - 3 * P * P; E3 = X * Y * Z + 2 * E2 * P + 4 * P * P * P;
    E4 = (2 * X * Y * Z + E2 * P + 3 * P * P * P) * P; E5 = X * Y * Z * P * P;
    return weight * (1 - 3 * E2 / 14 + E3 / 6 + 9 * E2 * E2 / 88 - 3 * E4 / 22 - 9 * E2 * E3 / 52 + 3 * E5 / 26)
        / (A * sqrt(A)) + 3 * total;
}
"""
_RJ = """
static double carlson_rj(double x, double y, double z, double p) {
    double q = -p, t, s;
    if (p > 0) return carlson_rj_positive(x, y, z, p);
    if (x > y) { t = x; x = y; y = t; }
    if (y > z) { t = y; y = z; z = t; }
    if (x > y) { t = x; x = y; y = t; }
    p = (y * (x + z + q) - x * z) / (y + q); s = x * z + p * q;
    return ((p - y) * carlson_rj_positive(x, y, z, p) - 3 * carlson_rf(x, y, z)
        + 3 * sqrt(x * y * z / s) * carlson_rc(s, p * q)) / (y + q);
}
"""
_RD = """
static double carlson_rd(double x, double y, double z) { return carlson_rj_positive(x, y, z, z); }
"""
_COMPLEX_POLE = """
#include <complex.h>
static double complex carlson_arc(double complex w) { return cabs(w) == 0 ? 1 : catan(w) / w; }
static double complex carlson_rc_complex(double x, double complex y) {
    double complex w = csqrt(y - x);
    double root = sqrt(x);
    return cabs(w) < root ? carlson_arc(w / root) / root : (1.57079632679489661923 - catan(root / w)) / w;
}
static double complex carlson_rj_complex(double x, double y, double z, double complex p) {
    double complex A = (x + y + z + 2 * p) / 5, total = 0, X, Y, Z, P, E2, E3, E4, E5;
    double complex product = (p - x) * (p - y) * (p - z);
    double weight = 1, bound = fmax(fmax(cabs(A - x), cabs(A - y)), fmax(cabs(A - z), cabs(A - p))) * 512.0;
    for (int i = 0; i < 60 && bound > cabs(A); i++) {
        double sx = sqrt(x), sy = sqrt(y), sz = sqrt(z), l = sx * sy + sx * sz + sy * sz;
        double complex sp = csqrt(p), d = (sp + sx) * (sp + sy) * (sp + sz);
        total += weight / d * carlson_arc(csqrt(product / (d * d)));
        weight /= 4; product /= 64; bound /= 4;
        x = (x + l) / 4; y = (y + l) / 4; z = (z + l) / 4; p = (p + l) / 4; A = (A + l) / 4;
    }
    X = (A - x) / A; Y = (A - y) / A; Z = (A - z) / A; P = -(X + Y + Z) / 2;
    E2 = X * Y + X * Z + Y * Z - 3 * P * P; E3 = X * Y * Z + 2 * E2 * P + 4 * P * P * P;
    E4 = (2 * X * Y * Z + E2 * P + 3 * P * P * P) * P; E5 = X * Y * Z * P * P;
    return weight * (1 - 3 * E2 / 14 + E3 / 6 + 9 * E2 * E2 / 88 - 3 * E4 / 22 - 9 * E2 * E3 / 52 + 3 * E5 / 26)
        / (A * csqrt(A)) + 6 * total;
}
"""
_COMPLEX_PARTS = {
    f"R_{kind}{part}": f"static double carlson_r{kind.lower()}{part}({given}, double a, double b) "
    f"{{ return c{'real' if part == 're' else 'imag'}(carlson_r{kind.lower()}_complex({called}, a + b * I)); }}\n"
    for kind, given, called in (("C", "double x", "x"), ("J", "double x, double y, double z", "x, y, z"))
    for part in ("re", "im")
}
_JACOBI = """
static void jacobi_all(double u, double m, double f[5]) { /* am, sn, cn, dn, epsilon */
    double k = m > 1 ? sqrt(m) : m < 0 ? sqrt(1 - m) : 1, v = k * u, phi, s, c, d, e, part[16], quotient[16];
    double inner = m > 1 ? 1 / m : m < 0 ? m / (m - 1) : m, a = 1, b = sqrt(1 - inner), scale = 1, squares = inner / 2;
    int n = 0;
    if (inner == 1) {
        phi = 2 * atan(tanh(v / 2)); s = e = tanh(v); c = d = 1 / cosh(v);
    } else {
        for (; n < 15 && fabs(a - b) > 1e-16 * a; n++) {
            double mean = (a + b) / 2;
            part[n] = (a - b) / 2; quotient[n] = part[n] / mean; squares += scale * part[n] * part[n];
            b = sqrt(a * b); a = mean; scale *= 2;
        }
        phi = scale * a * v; e = (1 - squares) * v;
        while (n > 0) { n--; e += part[n] * sin(phi); phi = (phi + asin(quotient[n] * sin(phi))) / 2; }
        s = sin(phi); c = cos(phi); d = sqrt(1 - inner + inner * c * c);
    }
    f[0] = phi; f[1] = s; f[2] = c; f[3] = d; f[4] = e;
    if (m > 1) { f[0] = asin(s / k); f[1] = s / k; f[2] = d; f[3] = c; f[4] = k * e - (m - 1) * u; }
    if (m < 0) {
        f[0] = phi + atan(s * c * (1 / k - 1) / (s * s / k + c * c)); f[1] = s / (k * d); f[2] = c / d; f[3] = 1 / d;
        f[4] = k * (e + m / (1 - m) * s * c / d);
    }
}
static double jacobi_part(double u, double m, int i) { double f[5]; jacobi_all(u, m, f); return f[i]; }
"""
_PARTS = {
    letter: f"static double jacobi_{letter}(double u, double m) {{ return jacobi_part(u, m, {i}); }}\n"
    for i, letter in enumerate(("am", "sn", "cn", "dn", "epsilon"))
}
_REDUCED = """
static double legendre_folded(double phi, double m, double f[4]) { /* sin, cos^2, 1 - m sin^2 within a half turn */
    double turns = rint(phi / 3.14159265358979323846);
    f[0] = sin(phi) * (fmod(turns, 2) == 0 ? 1 : -1); f[1] = cos(phi); f[1] *= f[1];
    f[2] = 1 - m + m * f[1]; f[3] = f[0] * f[0] * f[0] / 3;
    return turns;
}
"""
_K = """
static double legendre_k(double m) { return carlson_rf(0, 1 - m, 1); }
"""
_F = """
static double legendre_f(double phi, double m) {
    double f[4], turns = legendre_folded(phi, m, f), value = f[0] * carlson_rf(f[1], f[2], 1);
    return turns == 0 ? value : value + 2 * turns * carlson_rf(0, 1 - m, 1);
}
"""
_E = """
static double legendre_e(double phi, double m) {
    double f[4], turns = legendre_folded(phi, m, f);
    double value = f[0] * carlson_rf(f[1], f[2], 1) - m * f[3] * carlson_rd(f[1], f[2], 1);
    return turns == 0 ? value : value + 2 * turns * (carlson_rf(0, 1 - m, 1) - m * carlson_rd(0, 1 - m, 1) / 3);
}
"""
_PI = """
/* Abramowitz and Stegun 17.7.15: for n -> -infinity the first formula cancels */
static double legendre_third(double n, double m, double s, double square, double delta) {
    double first = s * carlson_rf(square, delta, 1), cube = s * s * s / 3;
    if (!(n < -1 && m >= 0))
        return first + n * cube * carlson_rj(square, delta, 1, 1 - n * s * s);
    double other = (m - n) / (1 - n), pole = square + s * s * (1 - m) / (1 - n);
    double third = first + other * cube * carlson_rj(square, delta, 1, pole);
    double arc = sqrt(-n / ((1 - n) * (m - n))) * atan(sqrt(-n * (m - n) / (1 - n)) * s * sqrt(square / delta));
    return ((1 - m) * -n / (1 - n) * third + m * first) / (m - n) + arc;
}
static double legendre_pi(double n, double phi, double m) {
    double f[4], turns = legendre_folded(phi, m, f);
    double value = legendre_third(n, m, f[0], f[1], f[2]);
    return turns == 0 ? value : value + 2 * turns * legendre_third(n, m, 1, 0, 1 - m);
}
"""
_LEGENDRE = {
    sp.elliptic_k: ("legendre_k", (_RF, _K)),
    sp.elliptic_f: ("legendre_f", (_RF, _REDUCED, _F)),
    sp.elliptic_e: ("legendre_e", (_RF, _RC, _RJ_POSITIVE, _RD, _REDUCED, _E)),
    sp.elliptic_pi: ("legendre_pi", (_RF, _RC, _RJ_POSITIVE, _RJ, _REDUCED, _PI)),
}
"""sympy's function → its name in C, and what it needs; complete integrals are those up to π/2."""
_NEEDED = {
    "R_F": (_RF,), "R_C": (_RC,), "R_D": (_RC, _RJ_POSITIVE, _RD), "R_J": (_RF, _RC, _RJ_POSITIVE, _RJ),
    **{letter: (_COMPLEX_POLE, text) for letter, text in _COMPLEX_PARTS.items()},
    **{letter: (_JACOBI, text) for letter, text in _PARTS.items()},
}  # fmt: skip


def in_c(expression: sp.Basic) -> sp.Basic:
    """Return an expression that ``sympy.ccode(…, allow_unknown_functions=True)`` can write.

    Legendre's integrals by name.
    """
    for function, (name, _) in _LEGENDRE.items():
        full = max(function.nargs)
        expression = expression.replace(
            function,
            lambda *given, name=name, full=full: sp.Function(name)(
                *(given if len(given) == full else (*given[:-1], sp.pi / 2, given[-1]))
            ),
        )
    return expression


def c_source(expression: sp.Basic) -> str:
    """Return the C functions that ``sympy.ccode(expression)`` calls, each once, in the order a compiler wants.

    Those of Legendre's integrals, which sympy does not write in C, are ``legendre_k(m)``, ``legendre_f(phi, m)``,
    ``legendre_e(phi, m)`` and ``legendre_pi(n, phi, m)``.

    Args:
        expression: any sympy object; functions that are not of this package are left to the C library.

    Returns:
        The text of the functions, to stand after ``#include <math.h>``; empty where none is needed.

    Raises:
        InvalidInputError: not a sympy object.
    """
    if not isinstance(expression, sp.Basic):
        raise InvalidInputError(f"c_source: a sympy expression is needed, not {expression!r}")
    letters = {function.letter for function in expression.atoms(Printable)}
    wanted = {part for letter in letters for part in _NEEDED[letter]}
    wanted |= {part for function, (_, parts) in _LEGENDRE.items() if expression.has(function) for part in parts}
    return "".join(part for part in _ORDER if part in wanted)


_ORDER = (
    _RF, _RC, _RJ_POSITIVE, _RD, _RJ, _REDUCED, _K, _F, _E, _PI,
    _COMPLEX_POLE, *_COMPLEX_PARTS.values(), _JACOBI, *_PARTS.values(),
)  # fmt: skip
