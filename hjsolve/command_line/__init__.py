"""The command line: arguments in, text out, one exit status.

In: the words of a command. Out: text on the terminal or a report's file, and 0, 1, 2 or 3 (see ``main.py``).
Read ``main.py`` first (the parser), then ``commands.py`` (what each command does). Heavy imports wait in the functions.
"""
