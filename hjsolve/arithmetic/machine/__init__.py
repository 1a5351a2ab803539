"""A register machine for formulas: instructions as data, run over many lanes of doubles by loops compiled once.

In: a tape (``hjsolve.arithmetic.tape``), run once in the arithmetic ``InstructionWriter``, which writes instructions
down instead of computing. Out: a ``MachineCode``, and a ``MachineProgram`` made of it with registers to work in. A
formula that nobody has seen before, or a new value of a parameter, compiles nothing.
Read ``writer.py`` first, then ``code.py`` and ``run.py``. The operations stand in ``operations.py``; the decorators of
kernels are in ``compiling.py``, and how their bundles of arrays pass from one to another in ``bundles.py``.
"""
