"""Ways to hand a robot on: as a table of Denavit and Hartenberg, as a URDF."""
