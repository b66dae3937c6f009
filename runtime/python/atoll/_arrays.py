"""Arrays that are copies of what a batch holds."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


class Copied(np.ndarray[Any, np.dtype[np.float64]]):
    """Read-only, so that nobody takes it for a view and writes to it; `.copy()` may be written to.

    Whoever takes it by DLPack, and may not know of read-only arrays, gets an array of their own.
    """

    def __dlpack__(self, **options: Any) -> Any:
        own = np.asarray(self) if self.flags.writeable else np.array(self)
        return own.__dlpack__(**options)

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        """What is computed from it is an array as any other."""
        return array[()] if return_scalar else np.asarray(array)


def copied(array: NDArray[np.float64]) -> Copied:
    array.flags.writeable = False
    return array.view(Copied)
