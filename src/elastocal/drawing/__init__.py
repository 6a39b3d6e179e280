"""Geometry and words to look at: solids, surfaces, SVG, numbers as people read them."""
