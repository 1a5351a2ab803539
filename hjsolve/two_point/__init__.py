"""Two places and a time: every motion that joins them (Greenwood (1977), §5-1; Lambert's problem for any system).

In: a solution, q0, q1, a time and numbers of turns. Out: ``Connections``. ``ask.py`` chooses the method:
``kepler`` (all conics), ``linear.py`` (formulas), ``one_freedom`` (proved), ``search`` (stated). Read ``ask.py`` first.
"""
