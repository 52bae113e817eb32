"""Rows of numbers as text, for key files: single precision in base64."""

import base64

import numpy as np

from wm3d.arrays import FloatArray

_STORED = np.dtype("<f4")


def packed(rows: FloatArray) -> str:
    """Return numbers in single precision, row by row, as base64."""
    return base64.b64encode(np.asarray(rows).astype(_STORED).tobytes()).decode()


def unpacked(text: str, columns: int, what: str) -> FloatArray:
    """Return the rows (k, columns) that were packed.

    Raises
    ------
    ValueError
        If the text is not base64 or no whole rows of finite numbers; it calls them `what`.
    """
    try:
        stored = base64.b64decode(text, validate=True)
    except ValueError as error:
        raise ValueError(f"{what} must be base64 ({error})") from None
    if len(stored) % (columns * _STORED.itemsize):
        raise ValueError(f"{what} must be rows of {columns} numbers, and {len(stored)} bytes are not")
    rows = np.frombuffer(stored, _STORED).reshape(-1, columns).astype(float)
    if not np.isfinite(rows).all():
        raise ValueError(f"{what} must be finite numbers")
    return rows
