"""The compiled core: the same numbers as NumPy, on every level."""
