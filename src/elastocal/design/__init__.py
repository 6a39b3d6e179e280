"""Optimal experiments: criteria, continuous and exact designs, bounds; knows no robot."""
