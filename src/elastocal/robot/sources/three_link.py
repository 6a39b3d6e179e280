"""Three-link anthropomorphic arm of the paper's section 5 (eq. 23)."""

from __future__ import annotations

import numpy as np

from elastocal.robot.chain import Joint, Robot, Tool, transform

LENGTHS = (0.75, 1.25, 1.10)  # l1, l2, l3 [m]


def three_link() -> Robot:
    """z = l1 + l2 sin q2 + l3 sin(q2 + q3): positive turns of J2 and J3 lift the arm."""
    l1, l2, l3 = LENGTHS
    up, lift = np.array([0.0, 0.0, 1.0]), np.array([0.0, -1.0, 0.0])
    joints = (
        Joint("J1", np.eye(4), up, False, -np.pi, np.pi),
        Joint("J2", transform(None, (0.0, 0.0, l1)), lift, False, -np.pi, np.pi),
        Joint("J3", transform(None, (l2, 0.0, 0.0)), lift, False, -np.pi, np.pi),
    )
    tip = Tool("tip", np.zeros(3), np.zeros((1, 3)), ("TCP",))
    return Robot("three-link", joints, transform(None, (l3, 0.0, 0.0)), {"tip": tip})
