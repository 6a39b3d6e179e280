"""How the arm bends: springs, the linear regressor, the exact equilibrium."""
