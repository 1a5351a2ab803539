"""Closed forms: the separated quadratures in elementary and elliptic functions, by regime, each verified.

In: a solution by quadratures, or a motion. Out: ``RegimeForms``. Read first: ``closed_forms.py`` (the verb),
``curves.py`` (P² as a curve y² = P(x)), ``elementary.py`` (the integrals of genus 0), ``derive.py`` (the regimes).
"""
