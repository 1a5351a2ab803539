"""Forms of separability: Levi-Civita's conditions, the Stäckel matrix, the Liouville form, each exact.

In: an energy shell. Out: the form it has, proved by substitution, or the pair of coordinates that forbids it.
Read ``levi_civita.py`` first, then ``stackel.py``; ``base_points.py`` and ``sparse_columns.py`` make its matrix
readable.
"""
