"""Calibrated robots for other programs: URDF, tables, values for a controller, JSON."""
