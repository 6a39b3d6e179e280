"""Certificates in words: what is proved of the best plan, and what rests on a search."""

from __future__ import annotations

import numpy as np

from elastocal.planning.certificate import Certificate
from elastocal.terminal.console import micrometres
from elastocal.wording.lists import counted
from elastocal.wording.plans import NOT_TRIED, floor_sentence, missed, searched
from elastocal.wording.proofs import proof_sentences

_OPEN = 5e-5  # gap between a design and its bound from which on it is said, ...
_OPEN_PROMISE = 1.1e-3  # ... where the search closes it no further


def certificate_sentences(certificate: Certificate, count: int) -> list[str]:
    """What the certificate of a plan says: what is proved, and what a search found.

    Args:
        certificate: The certificate.
        count: Number of experiments of the plan.
    """
    c = certificate
    if c.stopped:
        return [f"No certificate: {NOT_TRIED}."]
    if c.kind == "none":
        return [
            f"No certificate: {c.criterion} is not concave, so no bound on the best plan is known."
        ]
    return [" ".join(part) for part in (proof_sentences(c, count), [_found(c, count)]) if part]


def _found(c: Certificate, count: int) -> str:
    """What a search found of every plan, and how it searched."""
    share = 100.0 * (1.0 - np.sqrt(min(max(c.efficiency, 0.0), 1.0)))
    room = f"efficiency {c.efficiency:.4f}, at most {share:.2g} % to gain in the error"
    every = f"plan of {counted(count, 'experiment')}"
    if c.position_bound is not None:
        sentence = f"No {every} has {c.symbol} below {micrometres(c.position_bound)}: {room}"
    else:
        sentence = f"Against every {every}, by {c.criterion}: {room}"
    if c.proved is not None:
        sentence = f"By the search, which proves nothing: {sentence[0].lower()}{sentence[1:]}"
    sentence += (
        ". Numerical certificate: "
        + searched(c.fresh_starts, c.attained, c.narrow_starts, c.narrow_attained, c.rarest)
        + f" {missed(c.missed)}"
    )
    if c.peak_ratio > 1.0 + (_OPEN_PROMISE if c.promise else _OPEN) and not c.floored:
        open_ = 100.0 * (c.peak_ratio - 1.0)
        sentence += f" The search stopped early: the bound may be up to {open_:.2g} % too cautious."
    if c.floored:
        sentence += f" {floor_sentence(c.left_out)}"
    return sentence
