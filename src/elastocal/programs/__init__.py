"""A plan or a path as a robot program; one writer per controller."""
