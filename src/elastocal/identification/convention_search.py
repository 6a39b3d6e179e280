"""Which convention of the joint values the deflections tell.

In: an identification, how the controller counts as assumed. Out: the convention by which the same
springs fit best, if that is clearly another one. Signs and couplings alter the configurations, and
with them every row: loaded readings tell them as well as poses do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from elastocal.arrays import Array, unset
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import Doubt
from elastocal.identification.doubts import doubts
from elastocal.identification.linearised import linear_rows
from elastocal.identification.result import Identification
from elastocal.measuring.measurements import Measurements, chosen
from elastocal.measuring.whitening import noise_factors
from elastocal.robot.controller_axes import Coupling
from elastocal.robot.conventions import Convention, conventions

_ASKED = 60  # experiments that tell a convention
_CLEARLY = np.log(1000.0)  # of how much likelier another convention must be, besides their number
_LESS = 0.9  # residual over that of the assumed convention
_SAME = 1e-6  # change of the sum of squares by what does not matter
_READ_AS = ("controller", "model")
_SUSPICIOUS = ("all-negative", "negative", "all-held-at-zero", "held-at-zero", "explains-little")


@dataclass(frozen=True)
class OtherConvention:
    """A convention by which the same springs fit clearly better.

    Attributes:
        mistakes: What was wrong in the assumed one, each with the value that mends it; empty where
            the joint values were taken the other way.
        read_as: Whose the joint values are then: "controller" or "model", or either where the
            convention is its own inverse.
        before: Residual by the assumed one, root mean square over the readings [m].
        after: The same by this one.
        tried: How many were tried.
    """

    mistakes: tuple[Doubt, ...]
    read_as: tuple[str, ...]
    before: float
    after: float
    tried: int

    @property
    def doubt(self) -> Doubt:
        """It as one: joints that count the other way, and pairs of which one is coupled."""
        numbers = {"before": self.before, "after": self.after, "tried": float(self.tried)}
        turned: list[str] = []
        pairs: list[str] = []
        for mistake in self.mistakes:
            if mistake.code == "coupled":
                numbers["/".join(mistake.about)] = mistake.numbers["factor"]
                pairs += mistake.about
            else:
                numbers[mistake.about[0]] = mistake.numbers["sign"]
                turned += mistake.about
        numbers |= dict.fromkeys(self.read_as, 1.0)
        return Doubt("other-convention", tuple(turned), tuple(pairs), numbers)


def other_convention(found: Identification, table: Coupling) -> OtherConvention | None:
    """The convention that the readings tell, if it is another one; asked where a fit is doubtful.

    Args:
        found: The identification; its joint values came from what was shown by `table`.
        table: What the controller shows for the joint values of the model, as assumed.

    Source: ours; linear fits, the likelihoods of which are compared.
    """
    if not any(doubt.code in _SUSPICIOUS for doubt in doubts(found)):
        return None
    data, assumed = _some(found.measurements), Convention.of(table)
    shown = table.to_controller(data.cases.q)
    joints = _that_matter(found, data, assumed, shown)
    tried = list(conventions(found.arm.robot, assumed, joints))
    plain = [] if table.is_identity else [table.to_model(data.cases.q), shown]
    fits = _fits(found, data, [c.to_model(shown) for c in tried] + plain)
    now = fits[0]
    rows = 3 * len(data)
    best = min(fits, key=lambda fit: fit.square)
    # Of those that fit as well the one with the fewest changes.
    near = [i for i, fit in enumerate(fits) if fit.square <= best.square * (1.0 + _SAME)]
    i = min(near, key=lambda i: (len(tried[i].mistakes(assumed)) if i < len(tried) else 1, i))
    found_one = fits[i]
    gain = 0.5 * rows * np.log(now.square / max(found_one.square, 1e-300))
    if (
        gain < _CLEARLY + np.log(len(fits))
        or found_one.rms > _LESS * now.rms
        or found_one.negative > now.negative
    ):
        return None
    mistakes = tried[i].mistakes(assumed) if i < len(tried) else ()
    read_as = tuple(_READ_AS[j - len(tried)] for j in near if j >= len(tried))
    return OtherConvention(mistakes, () if mistakes else read_as, now.rms, found_one.rms, len(fits))


@dataclass(frozen=True)
class _Fit:
    """A linear fit: residuals squared over the noise, root mean square [m], negative ones."""

    square: float
    rms: float
    negative: int


def _some(data: Measurements) -> Measurements:
    """Experiments from all over the campaign, as many as it takes."""
    if len(data.cases) <= _ASKED:
        return data
    keep = np.zeros(len(data.cases), dtype=bool)
    keep[np.linspace(0, len(keep) - 1, _ASKED).astype(int)] = True
    return chosen(data, keep)


def _that_matter(
    found: Identification, data: Measurements, assumed: Convention, shown: Array
) -> list[int]:
    """Joints whose sign alters the fit."""
    n = len(assumed.names)
    each = [assumed, *(assumed.turned([i]) for i in range(n))]
    now, *others = _fits(found, data, [c.to_model(shown) for c in each])
    return [i for i, fit in enumerate(others) if abs(fit.square - now.square) > _SAME * now.square]


def _fits(found: Identification, data: Measurements, each: Sequence[Array]) -> list[_Fit]:
    """Linear fits of the fitted springs in configurations (N, n) each, all rows at once."""
    count, wrench = len(data.cases), np.tile(data.cases.wrench, (len(each), 1))
    many = replace(
        data,
        cases=LoadCases(np.concatenate(each), wrench),
        names=("",) * (count * len(each)),
        case=np.concatenate([data.case + count * i for i in range(len(each))]),
        marker=np.tile(data.marker, len(each)),
        deflection=np.tile(data.deflection, (len(each), 1)),
        covariance=np.tile(data.covariance, (len(each), 1, 1)),
        common=unset(),
        unloaded_of=np.arange(len(data) * len(each)),
    )
    arm = replace(found.arm, springs=found.model.springs, tool=data.tool)
    rows = linear_rows(arm, many).reshape(len(each), len(data), 3, -1)
    quiet = noise_factors(data.covariance)[1]
    free = [found.model.names.index(name) for name in found.fitted]
    rest = [i for i in range(len(found.model.names)) if i not in free]
    values = data.deflection - rows[..., rest] @ found.model.compliance[rest]
    white, right = quiet @ rows[..., free], np.einsum("rij,vrj->vri", quiet, values)
    position = ~data.rotations
    fits = []
    for a, b, raw, left in zip(white, right, rows[..., free], values, strict=True):
        flat = a.reshape(-1, len(free))
        scale = np.maximum(np.linalg.norm(flat, axis=0), 1e-300)
        k = np.linalg.lstsq(flat / scale, b.ravel(), rcond=1e-10)[0] / scale
        residual, open_ = b - a @ k, (left - raw @ k)[position]
        rms = float(np.sqrt(np.mean(np.sum(open_**2, axis=1)))) if len(open_) else float("nan")
        fits.append(_Fit(float(np.sum(residual**2)), rms, int(np.sum(k < 0.0))))
    return fits
