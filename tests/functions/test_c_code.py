"""The C functions, compiled and run, give the values of the sympy functions."""

import shutil
import subprocess

import pytest
import sympy as sp

from hjsolve.errors import InvalidInputError
from hjsolve.functions import (
    CarlsonRC,
    CarlsonRD,
    CarlsonRF,
    CarlsonRJ,
    JacobiAM,
    JacobiCN,
    JacobiDN,
    JacobiEpsilon,
    JacobiSN,
    c_source,
)

x, y, z, p = sp.symbols("x y z p", positive=True)


def test_only_what_is_called_is_written():
    assert c_source(sp.sin(x)) == ""
    text = c_source(CarlsonRD(x, y, z) + CarlsonRC(x, y))
    assert "carlson_rd" in text
    assert "carlson_rc" in text
    assert "jacobi" not in text
    assert "carlson_rf(" not in text


def test_what_is_no_expression_is_refused():
    with pytest.raises(InvalidInputError, match="a sympy expression"):
        c_source("x")


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_compiled_functions_give_the_values(tmp_path):
    functions = [
        CarlsonRF(x, y, z),
        CarlsonRC(x, y),
        CarlsonRC(x, -y),
        CarlsonRD(x, y, z),
        CarlsonRJ(x, y, z, p),
        CarlsonRJ(x, y, z, -p),
    ]
    functions += [f(p, k) for f in (JacobiAM, JacobiSN, JacobiCN, JacobiDN, JacobiEpsilon) for k in (x, -y, z + 1)]
    places = [(0.25, 2.0, 3.0, 4.0), (0.75, 1e-7, 40.0, 0.5), (0.999, 12.0, 0.125, 7.0)]
    text = "#include <math.h>\n#include <stdio.h>\n" + c_source(sp.Tuple(*functions))
    text += "static void at(double x, double y, double z, double p) {\n"
    text += "".join(f'    printf("%.17g\\n", {sp.ccode(function)});\n' for function in functions) + "}\n"
    text += "int main(void) {\n" + "".join(f"    at{place};\n" for place in places) + "    return 0;\n}\n"
    (tmp_path / "program.c").write_text(text)
    program = tmp_path / "program"
    subprocess.run(
        ["cc", "-std=c99", "-Wall", "-Werror", "-o", program, tmp_path / "program.c", "-lm"], check=True, timeout=100
    )
    printed = subprocess.run([program], check=True, capture_output=True, text=True, timeout=100).stdout.split()
    exact = [
        float(sp.N(f.subs(dict(zip((x, y, z, p), map(sp.Rational, place)))), 25)) for place in places for f in functions
    ]
    assert [float(number) for number in printed] == pytest.approx(exact, rel=2e-14, abs=1e-15)
