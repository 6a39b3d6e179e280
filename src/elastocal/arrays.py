"""Array types and read-only arrays for frozen values."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


def unset() -> Array:
    """The empty array that stands for "not given" in a frozen value."""
    return frozen([])


def freeze(value: object, /, *names: str, dtype: Any = np.float64, **arrays: ArrayLike) -> None:
    """Set fields of a frozen dataclass to read-only arrays, in its `__post_init__`.

    Args:
        value: The dataclass.
        names: Fields to copy as they are.
        dtype: Of all that are set.
        arrays: Other fields with what they become.
    """
    for name, array in ({name: getattr(value, name) for name in names} | arrays).items():
        object.__setattr__(value, name, frozen(array, dtype))


def frozen(values: ArrayLike, dtype: Any = np.float64) -> NDArray[Any]:
    """A read-only copy of `values`, so that a frozen dataclass is frozen all the way.

    What is such a copy already is not copied again.
    """
    if (
        type(values) is np.ndarray
        and values.dtype == dtype
        and values.flags.owndata
        and not values.flags.writeable
    ):
        return values
    array = np.array(values, dtype=dtype)
    array.setflags(write=False)
    return array
