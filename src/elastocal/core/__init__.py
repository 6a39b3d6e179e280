"""The compiled kernels: found and loaded, or NumPy does the work."""
