"""Solids of a robot and its cell, and the distances between them, in batches.

In: shapes, a robot, a tool. Out: pairs of convex solids to watch, and their signed distances.
`constraints/clearance.py` makes constraints of them.
"""
