"""Least squares, losses, influence, goodness of fit; knows no robot."""
