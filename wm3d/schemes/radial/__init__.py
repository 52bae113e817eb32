"""What the radial schemes share: histograms of distances from a centre, and their change by power maps."""

from wm3d.schemes.radial.histogram import MEAN, VARIANCE, Moment, Spread, exponents
from wm3d.schemes.radial.scheme import RadialScheme

__all__ = ["MEAN", "VARIANCE", "Moment", "RadialScheme", "Spread", "exponents"]
