"""Reference values computed another way than hjsolve computes them; nothing here imports hjsolve."""
