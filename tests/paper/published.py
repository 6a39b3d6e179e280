"""What the paper prints, as printed, and the repairs without which it does not reproduce.

Klimchik, Pashkevich, Wu, Caro, Furet: Calibration experiments planing for identification of
manipulator elastostatic parameters, Pomiary Automatyka Robotyka. Angles in degrees. How each
repair was found is told in docs/validation.md.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

# Section 5: the three-link arm. The text prints the test force as [0, .29, -.96]; Table 2 was
# computed with the unit vector at -73.3 degrees, of which that is the two-digit rounding.
TEST_CONFIGURATION = (0.0, 60.0, -45.0)
FORCE_IN_TEXT = np.array([0.0, 0.29, -0.96])
FORCE_IN_TABLE_2 = np.array([0.0, np.cos(np.radians(-73.3)), np.sin(np.radians(-73.3))])


@dataclass(frozen=True)
class Table2Row:
    """One plan of Table 2.

    Attributes:
        name: As in the first column, without the multiplier.
        repeats: The multiplier.
        rho0_squared: Printed ρ0² / σ².
        errors: Printed δk1, δk2, δk3 over σ.
        configurations: (q2, q3, α) of every load case, repaired where a remark says so.
        from_z: Whether α is counted from the z axis, F = (0, sin α, cos α), as in the rows of
            optimal plans, or from the y axis as eq. (30) says, as in the rows of the test pose.
    """

    name: str
    repeats: int
    rho0_squared: float
    errors: tuple[float, float, float]
    configurations: tuple[tuple[float, float, float], ...]
    from_z: bool = True


_TEST = ((60.0, -45.0, -73.3),)  # q3 is printed as +45
_OPT1 = ((43.2, -57.3, 22.9),)
_OPT2 = ((5.5, -6.8, 26.3), (93.1, -101.2, 3.3))
_OPT3 = ((173.3, 19.3, 0.5), (-7.1, 14.7, -34.9), (-49.3, -125.0, 2.1))  # -34.9 printed -24.9
_OPT4 = ((28.3, -39.1, 9.7), (4.6, -12.6, 22.4), (-3.4, -4.8, -37.4), (146.8, -150.6, -5.2))

TABLE_2 = (
    Table2Row("Test", 1, 3.00, (1.22, 0.70, 2.19), _TEST, False),
    Table2Row("Opt1", 1, 1.92, (0.66, 0.52, 1.81), _OPT1),
    Table2Row("Test", 2, 1.50, (0.86, 0.49, 1.55), _TEST, False),
    Table2Row("Opt1", 2, 0.96, (0.47, 0.37, 1.28), _OPT1),
    Table2Row("Opt2", 1, 0.80, (0.41, 0.30, 0.96), _OPT2),
    Table2Row("Test", 3, 1.00, (0.71, 0.40, 1.27), _TEST, False),
    Table2Row("Opt1", 3, 0.64, (0.38, 0.30, 1.05), _OPT1),
    Table2Row("Opt3", 1, 0.51, (0.32, 0.23, 0.83), _OPT3),
    Table2Row("Test", 4, 0.75, (0.61, 0.35, 1.10), _TEST, False),
    Table2Row("Opt1", 4, 0.48, (0.33, 0.26, 0.91), _OPT1),
    Table2Row("Opt2", 2, 0.40, (0.29, 0.21, 0.68), _OPT2),
    Table2Row("Opt4", 1, 0.39, (0.25, 0.21, 0.78), _OPT4),
)

# Section 6: the KUKA KR-270. q1 plays no part: a vertical force and (38) fix it at zero.
MACHINING_CONFIGURATION = (0.0, -56.9, 89.3, 45.1, 76.0, 57.2)
MACHINING_FORCE = np.array([0.0, 280.0, -180.0])
CALIBRATION_FORCE = np.array([0.0, 0.0, -2500.0])
SIGMA = 0.03e-3  # m per axis

A0 = np.array(
    [
        [-73.4, -177.4, -106.1, 102.4, 0.0],
        [0.0, 0.0, 197.2, 19.3, 0.0],
        [-363.6, -98.3, -167.1, -42.2, 0.0],
    ]
)  # eq. (38), N·m²
A0_PLUS = np.where(A0 > 0.0, A0, 0.0)  # what Table 7 was computed with

TABLE_5 = {
    2: ((-99.9, 114.3, -48.5, 28.1, -180.0), (-67.8, -94.0, 137.5, -111.9, 76.9)),
    3: (
        (-93.5, 125.0, -118.7, -62.4, -168.9),
        (-103.4, 93.4, -147.9, 105.8, 93.2),
        (-98.9, 113.8, 50.6, -38.6, 16.8),
    ),
    4: (
        (-81.1, 64.9, -55.4, 42.2, 149.7),
        (-96.6, 15.4, 112.1, -19.7, 178.4),
        (-111.2, -69.0, 133.5, 113.9, -118.8),
        (-108.1, 93.5, -34.2, -108.9, 73.3),
    ),
    6: (
        (-84.0, 126.9, -119.4, -61.2, -172.9),
        (-105.5, 98.6, -148.2, 99.7, 94.7),
        (-106.0, 106.8, 49.4, -38.5, 22.2),
        (-89.2, 132.3, -119.2, -61.4, -173.9),
        (-96.7, 86.6, -147.1, 102.3, 96.0),
        (-99.4, 108.8, 51.8, -39.1, 17.6),
    ),
    12: (
        (-83.8, 127.6, -120.0, -60.9, -173.8),
        (-105.9, 99.1, -148.5, 100.1, 94.7),
        (-105.7, 107.1, 49.4, -39.1, 22.1),
        (-89.4, 131.6, -119.0, -61.4, -172.8),
        (-97.1, 85.8, -146.8, 101.5, 96.1),
        (-99.4, 107.8, 52.8, -39.9, 17.6),
        (-83.3, 126.1, -118.9, -60.3, -171.9),
        (-106.2, 98.1, -148.0, 99.7, 95.1),
        (-106.1, 106.5, 49.6, -38.1, 21.6),
        (-89.8, 133.4, -119.0, -60.8, -174.0),
        (-97.6, 85.9, -146.3, 102.7, 96.3),
        (-98.9, 109.6, 52.6, -39.5, 18.2),
    ),
}  # q2 to q6 of every load case

TABLE_6 = {
    2: (6.55, 6.88, 24.0, 34.5, 71.9),
    3: (5.74, 6.87, 19.2, 26.4, 74.9),
    4: (3.72, 6.96, 16.9, 21.2, 66.9),
    6: (3.93, 4.82, 13.8, 16.4, 55.2),
    12: (2.78, 3.41, 9.75, 11.6, 38.8),
}  # standard errors of k2 to k6, 1e-9 rad/(N·m)

TABLE_7 = {
    (2, 2): 5.989,
    (3, 3): 4.676,
    (4, 2): 4.235,
    (4, 4): 4.044,
    (6, 2): 3.458,
    (6, 3): 3.306,
    (6, 6): 3.228,
    (12, 2): 2.445,
    (12, 3): 2.338,
    (12, 4): 2.335,
    (12, 6): 2.283,
    (12, 12): 2.282,
}  # ρ0 in 1e-3 mm, by (experiments, configurations)
