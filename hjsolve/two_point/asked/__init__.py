"""What two_point is asked and what it answers, whichever method finds the motions.

In: places, a time and turns as the user wrote them. Out: a checked question, the answers, and the check that a
motion is at q1 at the time asked. Read ``answers.py`` first.
"""
