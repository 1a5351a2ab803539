"""Lambert's problem."""
