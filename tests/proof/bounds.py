"""Bounds of studies without a search: the V of a design of load cases by chance."""

from __future__ import annotations

import numpy as np

from elastocal.design.continuous import ContinuousDesign
from elastocal.design.criterion import InformationFunction
from elastocal.design.dual_bound import DualBound
from elastocal.design.oracle import sensitivity
from elastocal.design.space import information
from elastocal.matrices import square_root
from elastocal.planning.aim import aim_of
from elastocal.planning.certificate import Bound
from elastocal.study.study import Study


def bound_by_chance(study: Study, seed: int = 0, count: int = 40) -> Bound:
    """A bound whose gradient is taken at `count` feasible load cases by chance."""
    aim = aim_of(study)
    x = aim.space.sample(count, np.random.default_rng(seed))
    informations = information(aim.space.evaluate(x).blocks)
    weights = np.full(len(x), 1.0 / len(x))
    total = aim.base / aim.count + informations.mean(axis=0)
    assert isinstance(aim.criterion, InformationFunction)
    gradient = aim.criterion.gradient(total[None])[0]
    s = sensitivity(aim.space, x, square_root(gradient))
    dual = DualBound(
        gradient=gradient,
        offset=float(np.sum(gradient * aim.base / aim.count)),
        largest=float(s.max()),
        x_largest=x[s.argmax()],
        starts=0,
        attained=0,
        narrow_starts=0,
        narrow_attained=0,
        rarest=0,
        x_found=x,
        s_found=s,
    )
    design = ContinuousDesign(x, weights, informations, total, dual, np.inf)
    return Bound(aim, aim.criterion, design)
