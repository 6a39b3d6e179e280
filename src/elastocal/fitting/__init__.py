"""Fitting: rows, values, losses, influence. Nothing here knows a robot."""
