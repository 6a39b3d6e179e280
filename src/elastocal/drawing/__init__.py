"""Geometry to look at: solids, surfaces, SVG."""
