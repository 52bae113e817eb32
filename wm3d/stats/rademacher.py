"""A detector statistic as a function of the key's signs, the score of one key, and signs from a seed."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from wm3d.arrays import FloatArray, SignArray
from wm3d.errors import Wm3dError
from wm3d.stats.tail import log10_tail, z_at
from wm3d.stats.weights import checked_weights, norm

DEFAULT_PF = 1e-6
"""The false-alarm probability at which a mark counts as found, unless the caller names another."""


def checked_pf(pf: float) -> float:
    """Return a false-alarm probability, or raise `Wm3dError` if it is not above 0 and at most 1."""
    if not 0 < pf <= 1:
        raise Wm3dError(f"The false-alarm probability is {pf}; it must be above 0 and at most 1.")
    return pf


@dataclass(frozen=True, eq=False)
class RademacherSum:
    """The statistic of a detector for ±1 keys, given the mesh under test: offset + Σ b_k w_k.

    Parameters
    ----------
    offset : float
        The part that does not depend on the key (Σ a_k of the paper's log-likelihood ratio).
    b : (n,) array_like of float
        Weight of each key sign; zero where a coefficient is not read. Copied and made read-only.
    tries : int
        Of how many such statistics this is the one that was chosen, where the choice may know the key. The
        p-value is as many times that of this one (Bonferroni), and holds whatever the choice was.

    Raises
    ------
    Wm3dError
        If the offset or a weight is not finite.
    """

    offset: float
    b: FloatArray
    tries: int = 1

    def __post_init__(self) -> None:
        weights = checked_weights(self.b).copy()
        weights.flags.writeable = False
        object.__setattr__(self, "b", weights)
        if not math.isfinite(self.offset):
            raise Wm3dError(f"The offset of the statistic is {self.offset}; it must be finite.")

    @cached_property
    def scale(self) -> float:
        """Standard deviation √(Σ b²) of the statistic over uniform keys."""
        return norm(self.b)

    @cached_property
    def log10_p_least(self) -> float:
        """Log10 of the least p-value that any key can reach: one key among 2^(nonzero weights)."""
        reach = float(np.abs(self.b).sum())
        return float(self.log10_p(reach / self.scale)) if self.scale > 0 else 0.0

    @property
    def decoded(self) -> SignArray:
        """The message that is read, (n,) of int8: the sign of each weight, 0 where nothing is read."""
        return np.sign(self.b).astype(np.int8)

    def bit_error_rate(self, signs: ArrayLike) -> float:
        """Return the share of signs that are read wrong; one that is not read at all counts as one half.

        Parameters
        ----------
        signs : (n,) array_like
            The message w, each ±1.
        """
        return float((1 - self.decoded * self._checked(signs)).mean() / 2)

    def score(self, signs: ArrayLike) -> "Score":
        """Return the statistic of one key with its exact p-value over uniform keys.

        Parameters
        ----------
        signs : (n,) array_like
            The key w, each ±1.

        Raises
        ------
        Wm3dError
            If the signs are not as many as the weights, or not all ±1.
        """
        total = float(self.b @ self._checked(signs))
        z = total / self.scale if self.scale > 0 else 0.0
        return Score(self.offset + total, z, float(self.log10_p(z)), self)

    def log10_p(self, z: ArrayLike) -> FloatArray:
        """Return the log10 of the p-value of each z, times `tries`; the shape of `z`."""
        tail = log10_tail(self.b, np.asarray(z, dtype=np.float64))
        return np.minimum(0.0, tail + math.log10(self.tries))

    def z_at(self, log10_pf: float) -> float:
        """Return the least z whose p-value, times `tries`, is at most 10**log10_pf; ∞ where no key has it.

        Raises
        ------
        Wm3dError
            If log10_pf is not below 0.
        """
        return z_at(self.b, log10_pf - math.log10(self.tries))

    def _checked(self, signs: ArrayLike) -> FloatArray:
        w = np.asarray(signs, dtype=np.float64)
        if w.shape != self.b.shape:
            raise Wm3dError(f"The key has shape {w.shape}, but the statistic reads {self.b.shape} signs.")
        if not (np.abs(w) == 1).all():
            raise Wm3dError("A key consists of the signs +1 and -1 only.")
        return w


@dataclass(frozen=True, eq=False)
class Score:
    """What a detector found for one key on one mesh.

    Parameters
    ----------
    statistic : float
        The detector's statistic, offset + Σ b_k w_k.
    z : float
        Σ b_k w_k / √(Σ b²): mean 0 and variance 1 over uniform keys.
    log10_p : float
        log10 of the probability that a uniform key gives this statistic or more on the same mesh, times the
        `tries` of the null.
    null : RademacherSum
        The statistic as a function of the key.
    """

    statistic: float
    z: float
    log10_p: float
    null: RademacherSum = field(repr=False)

    @property
    def p_value(self) -> float:
        """The p-value 10**log10_p; underflows to 0 below 10^−323."""
        return float(10.0**self.log10_p)

    def detected(self, pf: float = DEFAULT_PF) -> bool:
        """Return whether the mark is found at the false-alarm probability `pf`, above 0 and at most 1."""
        return self.log10_p <= math.log10(checked_pf(pf))


def key_signs(seed: int, n: int) -> SignArray:
    """Return the watermark w of a seed: n independent uniform signs.

    Parameters
    ----------
    seed : int
        Any non-negative integer; digests of 256 bits are welcome.
    n : int
        How many signs.

    Returns
    -------
    (n,) ndarray of int8
        +1 or -1.

    Raises
    ------
    Wm3dError
        If the seed or n is negative.

    Notes
    -----
    The bits of PCG64's raw output, least significant first. NumPy guarantees that raw stream across its
    releases; it does not guarantee the methods of `numpy.random.Generator`, and a key must outlive them.
    A longer key starts with the shorter key of the same seed.
    """
    signs: SignArray = key_signs_batch([seed], n)[0]
    return signs


def key_signs_batch(seeds: Iterable[int], n: int) -> SignArray:
    """Return the watermarks of many seeds, one row each: row i equals ``key_signs(seeds[i], n)``.

    Parameters
    ----------
    seeds : iterable of int
        Non-negative integers.
    n : int
        How many signs a key has.

    Returns
    -------
    (len(seeds), n) ndarray of int8
        +1 or -1.
    """
    seeds = [int(seed) for seed in seeds]
    if n < 0:
        raise Wm3dError(f"The number of signs is {n}; it cannot be negative.")
    if seeds and min(seeds) < 0:
        raise Wm3dError(f"The seed is {min(seeds)}; a seed is a non-negative integer.")
    words = np.empty((len(seeds), -(-n // 64)), dtype="<u8")
    for row, seed in zip(words, seeds, strict=True):
        row[:] = np.random.PCG64(np.random.SeedSequence(seed)).random_raw(row.size)
    bits = np.unpackbits(words.view(np.uint8), axis=1, count=n, bitorder="little")
    signs: SignArray = 2 * bits.view(np.int8) - 1
    return signs
