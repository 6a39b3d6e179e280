"""Equilibria near known ones: where the same load cases come to rest with compliances beside.

In: elastic arm, load cases, compliances. Out: deflections as series to third order in the changes
of some compliances, for many changes at once. What is left out is of fourth order: where
compliances are a few percent off, less than rounding. Source: ours.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, combinations_with_replacement, permutations

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.deflections import deflection_and_gradient
from elastocal.elastic.load_cases import LoadCases

_APART = 0.02  # of a compliance, between which derivatives are compared
_ROUNDING = 1e-12  # of a deflection, up to which a series counts as exact


@dataclass(frozen=True)
class Series:
    """m values as polynomials of the changes of p unknowns.

    Attributes:
        value: (m,) values at the centre.
        terms: (p, m), (p, p, m) and (p, p, p, m) coefficients of the first three orders, symmetric.
    """

    value: Array
    terms: tuple[Array, Array, Array]

    @cached_property
    def _monomials(self) -> tuple[IntArray, IntArray, tuple[Array, Array, Array]]:
        """Products x_i x_j and x_i x_j x_k of p unknowns, each once, and what each order adds.

        (2, P) unknowns of the pairs; (2, T) pair and unknown of the triples; coefficients (p, m),
        (P, m) and (T, m).
        """
        first, second, third = self.terms
        p = len(first)
        pairs = list(combinations_with_replacement(range(p), 2))
        triples = list(combinations_with_replacement(range(p), 3))
        ways = [{*permutations(each)} for each in (*pairs, *triples)]
        times = np.array([len(each) for each in ways], dtype=float)[:, None]
        of_pairs = times[: len(pairs)] * np.array([second[each] for each in pairs])
        of_triples = times[len(pairs) :] * np.array([third[each] for each in triples])
        split = [(pairs.index(each[:2]), each[2]) for each in triples]
        return np.array(pairs).T, np.array(split).T, (first, of_pairs, of_triples)

    def gradient(self, change: Array) -> Array:
        """(C, m, p) derivatives for changes (C, p)."""
        count, p = change.shape
        first, second, third = self.terms
        (i, j), _, _ = self._monomials
        twice = np.where(i == j, 3.0, 6.0)[:, None, None] * third[i, j]
        found = 2.0 * change @ second.reshape(p, -1)
        found += (change[:, i] * change[:, j]) @ twice.reshape(len(i), -1)
        found += first.ravel()
        return found.reshape(count, p, -1).transpose(0, 2, 1)

    def at(self, change: Array) -> tuple[Array, BoolArray]:
        """(C, m) values for changes (C, p), and for which (C,) of them nothing is left out.

        The fourth order is taken to be to the third as that to the second, four times over.
        """
        (i, j), (pair, k), factors = self._monomials
        pairs = change[:, i] * change[:, j]
        powers = change, pairs, pairs[:, pair] * change[:, k]
        first, second, third = (a @ b for a, b in zip(powers, factors, strict=True))
        value = self.value + first + second + third
        of_second, of_third, size = (np.abs(each).max(axis=1) for each in (second, third, value))
        return value, 4.0 * of_third**2 <= _ROUNDING * size * of_second


def deflection_series(
    arm: ElasticArm, compliance: Array, cases: LoadCases, free: IntArray
) -> Series | None:
    """The 3T N deflections of load cases about compliances (c,), of which those at `free` change.

    None where one of these is not positive: there is no scale for its changes.

    Raises:
        EquilibriumError: a load case has no stable equilibrium there.

    Source: ours; derivatives by central differences of exact gradients.
    """
    p, apart = len(free), _APART * compliance[free]
    if not (apart > 0.0).all():
        return None
    pairs = list(combinations(range(p), 2))
    signs = np.zeros((1 + 2 * p + 4 * len(pairs), p))
    signs[1 : 2 * p + 1 : 2], signs[2 : 2 * p + 2 : 2] = np.eye(p), -np.eye(p)
    for row, (i, j) in zip(range(2 * p + 1, len(signs), 4), pairs, strict=True):
        signs[row : row + 4, i], signs[row : row + 4, j] = (1, 1, -1, -1), (1, -1, 1, -1)
    each = np.tile(compliance, (len(signs), 1))
    each[:, free] += signs * apart
    many = LoadCases(np.tile(cases.q, (len(signs), 1)), np.tile(cases.wrench, (len(signs), 1)))
    value, gradient = deflection_and_gradient(arm, np.repeat(each, len(cases), axis=0), many)
    # Everything in shares of the steps, so that differences of all unknowns are alike.
    slope = gradient[..., free].reshape(len(signs), -1, p).transpose(0, 2, 1) * apart[:, None]
    up, down = slope[1 : 2 * p + 1 : 2], slope[2 : 2 * p + 2 : 2]
    second = (up - down) / 2.0
    third = np.zeros((p, p, *slope.shape[1:]))
    third[range(p), range(p)] = up + down - 2.0 * slope[0]
    for row, (i, j) in zip(range(2 * p + 1, len(signs), 4), pairs, strict=True):
        third[i, j] = third[j, i] = (
            slope[row] - slope[row + 1] - slope[row + 2] + slope[row + 3]
        ) / 4.0
    second = (second + second.transpose(1, 0, 2)) / 4.0
    third = (third + third.transpose(1, 2, 0, 3) + third.transpose(2, 0, 1, 3)) / 18.0
    return Series(
        value[: len(cases)].ravel(),
        (
            slope[0] / apart[:, None],
            second / (apart[:, None, None] * apart[:, None]),
            third / (apart[:, None, None, None] * apart[:, None, None] * apart[:, None]),
        ),
    )
