"""Lambert's problem as a loop over numbers, compiled where numba is installed."""
