"""What every 2-D mark of a range image offers: embed, evidence, and a strength that can be scaled."""

from abc import ABC, abstractmethod
from typing import Annotated, ClassVar, Self

from pydantic import Field

from wm3d.arrays import BoolArray, FloatArray, SignArray
from wm3d.component import Component
from wm3d.stats import RademacherSum

MAX_ALPHA = 1e50
"""Largest α: its fourth power, in the likelihood of a generalized Gaussian of shape 4, is still finite."""

Alpha = Annotated[float, Field(gt=0, le=MAX_ALPHA)]


class ImageMark(Component, ABC):
    """A watermark of ±1 signs in an image of grey levels that span [0, 255].

    Attributes
    ----------
    strength : str
        The field that scales what is added to the image.
    """

    strength: ClassVar[str] = "alpha"

    @abstractmethod
    def capacity(self, shape: tuple[int, int]) -> int:
        """Return how many signs an image of this shape carries."""

    @abstractmethod
    def carried(self, usable: BoolArray) -> BoolArray:
        """Return which signs have a place in the image.

        Parameters
        ----------
        usable : (rows, columns) ndarray of bool
            Pixels that may be changed and read.

        Returns
        -------
        (capacity,) ndarray of bool
        """

    @abstractmethod
    def embed(self, image: FloatArray, signs: SignArray, usable: BoolArray | None = None) -> FloatArray:
        """Return the marked image, neither clipped nor rounded.

        Parameters
        ----------
        image : (rows, columns) ndarray
            Grey levels in [0, 255].
        signs : (capacity,) ndarray
            w, ±1.
        usable : (rows, columns) ndarray of bool, optional
            Other pixels stay as they are.
        """

    @abstractmethod
    def evidence(self, image: FloatArray, usable: BoolArray | None = None) -> RademacherSum:
        """Return the detection statistic as a function of the key; parameters as for `embed`.

        What pixels hold that are not usable does not matter.
        """

    def scaled(self, factor: float) -> Self:
        """Return this mark with its strength multiplied by a factor."""
        return self.model_copy(update={self.strength: factor * getattr(self, self.strength)})
