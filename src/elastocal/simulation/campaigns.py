"""What virtual campaigns came to: estimates, and the errors they leave at the test poses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, BoolArray
from elastocal.identification.fit import Fit
from elastocal.squares import largest_likely


@dataclass(frozen=True)
class Campaigns:
    """K virtual campaigns of one plan that fit p compliances, judged at T test poses.

    Attributes:
        name: Name of the plan.
        experiments: Experiments in each campaign.
        truth: (p,) true compliances [rad/(N·m) or m/N].
        estimate: (K, p) estimates.
        standard_error: (K, p) as each campaign reports them.
        inside: (K, p) whether the 95 % intervals that they report hold the truth.
        covariance: (p, p) predicted from the plan alone.
        error: (K, T) distance between target and tool at the test poses after compensation [m]; of
            a path its root mean square.
        weight: (T,) weights of the test poses, of sum 1.
        squares: The squared error over the test poses is predicted to be Σ w z² with these weights
            w [m²] and standard normal numbers z, to first order.
        rho0_each: (T,) predicted root mean squares of `error` [m].

    Source: paper eqs. (13), (17), (20).
    """

    name: str
    experiments: int
    truth: Array
    estimate: Array
    standard_error: Array
    inside: BoolArray
    covariance: Array
    error: Array
    weight: Array
    squares: Array
    rho0_each: Array

    @property
    def predicted_error(self) -> Array:
        """(p,) predicted standard errors."""
        return np.sqrt(np.diagonal(self.covariance))

    @property
    def bias(self) -> Array:
        """(p,) mean estimate minus truth, in predicted standard errors."""
        return np.asarray((self.estimate.mean(axis=0) - self.truth) / self.predicted_error)

    @property
    def spread(self) -> Array:
        """(p,) standard deviation of the estimates over the predicted one."""
        return np.asarray(self.estimate.std(axis=0, ddof=1) / self.predicted_error)

    @property
    def coverage(self) -> Array:
        """(p,) share of the 95 % intervals that contain the truth."""
        return np.asarray(np.mean(self.inside, axis=0))

    @property
    def rho0(self) -> float:
        """Predicted root mean square error over test poses and campaigns [m]."""
        return float(np.sqrt(self.weight @ self.rho0_each**2))

    @property
    def limit(self) -> float:
        """What `total` is predicted to stay below in 95 % of the campaigns [m]."""
        return largest_likely(self.squares)

    @property
    def within(self) -> float:
        """Share of the campaigns in which it does."""
        return float(np.mean(self.total <= self.limit))

    @property
    def total(self) -> Array:
        """(K,) root mean square error over the test poses [m]."""
        return np.asarray(np.sqrt(self.error**2 @ self.weight))

    @property
    def rms(self) -> float:
        """Root mean square error found [m]."""
        return float(np.sqrt(np.mean(self.total**2)))

    def likelihood_ratio(self) -> tuple[float, float]:
        """Statistic and p-value of "the estimates scatter as predicted".

        With S the covariance of the whitened estimates about their mean, ν (tr S - log det S - p)
        with ν = K - 1 follows χ² with p (p + 1)/2 degrees of freedom.

        Source: Anderson, An Introduction to Multivariate Statistical Analysis, ch. 10.
        """
        from scipy.special import chdtrc

        scale = self.predicted_error
        root = np.linalg.cholesky(self.covariance / np.outer(scale, scale))
        white = np.linalg.solve(root, ((self.estimate - self.truth) / scale).T)
        p, count = white.shape
        found = np.cov(white).reshape(p, p)
        statistic = (count - 1) * (np.trace(found) - np.linalg.slogdet(found)[1] - p)
        return float(statistic), float(chdtrc(p * (p + 1) / 2, statistic))


@dataclass(frozen=True)
class RandomCampaigns:
    """K virtual campaigns of each of R random plans that the study allows.

    Attributes:
        experiments: Experiments in each campaign.
        drawn: How many plans were drawn; those that do not tell the compliances apart, or whose
            campaigns cannot be fitted, are left out.
        rho0_each: (R,) predicted root mean square error of each plan [m].
        total: (R, K) root mean square error over the test poses in each campaign [m].
    """

    experiments: int
    drawn: int
    rho0_each: Array
    total: Array

    @property
    def name(self) -> str:
        """What tables and charts call them."""
        return f"{len(self.rho0_each)} random plans"

    @property
    def rho0(self) -> float:
        """Predicted root mean square error over plans and campaigns [m]."""
        return float(np.sqrt(np.mean(self.rho0_each**2)))

    @property
    def rms(self) -> float:
        """Root mean square error found [m]."""
        return float(np.sqrt(np.mean(self.total**2)))


@dataclass(frozen=True)
class MonteCarlo:
    """Virtual campaigns of several plans.

    Attributes:
        springs: Names of the p fitted compliances: those to identify, and those that each campaign
            knew as well as the study does.
        known: Springs of the truth that are not fitted; every campaign knew them.
        test_poses: Names of the T test poses.
        plans: The campaigns of each plan.
        number: Campaigns of each plan.
        seed: Seed of the first.
        how: How they were fitted.
        linear: Whether the truth was linear.
        nuisance: Whether each campaign was on a robot of its own, with nuisance, which was fitted.
        random: Campaigns of random plans beside; None if there are none.
    """

    springs: tuple[str, ...]
    known: tuple[str, ...]
    test_poses: tuple[str, ...]
    plans: tuple[Campaigns, ...]
    number: int
    seed: int
    how: Fit
    linear: bool
    random: RandomCampaigns | None = None
    nuisance: bool = False
