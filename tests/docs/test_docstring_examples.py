"""The examples in public docstrings are run, and print what they say."""

import doctest
import inspect

import numpy as np
import pytest
import sympy as sp

import hjsolve

FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
NAMES = [name for name in hjsolve.__all__ if callable(getattr(hjsolve, name))]
WITH = [name for name in NAMES if ">>>" in (inspect.getdoc(getattr(hjsolve, name)) or "")]


@pytest.mark.nightly_cases("cost", "wavefronts", "energy_momentum_map", "figures", "Wavefronts", "EnergyMomentumMap")
@pytest.mark.parametrize("name", WITH)
def test_the_example_of_a_docstring_prints_what_it_says(name):
    known = {public: getattr(hjsolve, public) for public in hjsolve.__all__} | {"np": np, "sp": sp, "hjsolve": hjsolve}
    test = doctest.DocTestParser().get_doctest(inspect.getdoc(getattr(hjsolve, name)), known, name, None, 0)
    told = []
    doctest.DocTestRunner(optionflags=FLAGS).run(test, out=told.append)
    assert not told, "".join(told)


def test_verbs_and_results_have_an_example():
    verbs = [name for name in NAMES if inspect.isfunction(getattr(hjsolve, name))]
    results = ["System", "Separation", "Obstruction", "Solution", "Motion", "State", "Batch", "Estimate", "Scene"]
    assert sorted({*verbs, *results} - set(WITH)) == []
