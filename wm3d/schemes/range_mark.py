"""The paper's pose, scan and vertex moves with any 2-D mark in the range image."""

from typing import Annotated, ClassVar, Literal, Self

from pydantic import ConfigDict, model_validator

from wm3d.imagemarks import IMAGEMARKS, DctAdditive, ImageMark
from wm3d.imagemarks.base import MAX_ALPHA, Alpha
from wm3d.registry import OneOf
from wm3d.schemes.range_scheme import RangeScheme


class RangeMark(RangeScheme):
    """Any 2-D mark in the range image of a virtual cylindrical scanner.

    Attributes
    ----------
    alpha : float
        Factor on the strength of `mark`.
    mark : ImageMark
        What is embedded in the grey levels of the region.
    """

    # the registry is read when the first scheme is made: entry points may import this package
    model_config = ConfigDict(defer_build=True)

    name: Literal["range-mark"] = "range-mark"
    legend: ClassVar[tuple[str, ...]] = ("mark",)

    alpha: Alpha = 1.0
    mark: Annotated[ImageMark, OneOf(IMAGEMARKS)] = DctAdditive()

    @model_validator(mode="after")
    def _strength_within_bounds(self) -> Self:
        if not getattr(self.image_mark, self.mark.strength) <= MAX_ALPHA:
            raise ValueError(
                f"alpha times the {self.mark.strength} of the mark must not exceed {MAX_ALPHA:g}"
            )
        return self

    @property
    def engines(self) -> tuple[str, ...]:
        """The packages behind the mark."""
        return self.mark.engines

    @property
    def image_mark(self) -> ImageMark:
        """The mark, its strength multiplied by α."""
        return self.mark.scaled(self.alpha)
