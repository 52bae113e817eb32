"""A change of what a scheme reads must raise its version: cells of a run and keys are told apart by it."""

import numpy as np
import pytest
from shapes import blob

from wm3d.attacks import Chain, Crop, GaussianNoise, Mirror, Similarity, Simplify
from wm3d.schemes import SCHEMES

ORIGINAL = blob(1, 4)
ATTACKS = (
    Chain(then=(GaussianNoise(percent=0.1), Similarity())),
    Simplify(ratio=0.3, simplifier="clustering"),
    Mirror(),
    Chain(then=(Mirror(), Crop(percent=20), Similarity())),  # for which range-dct must search
)
READ = {
    "cho2007-mean": (1, [6.438, 0.865, 7.471]),
    "cho2007-variance": (1, [5.756, 0.129, 7.695]),
    "ohbuchi2002": (1, [16.7, 8.3]),  # its modes hang on the BLAS: 7.5 to 9.2 with one thread and two
    "radial-area": (1, [6.694, 1.384, 6.932]),
    "range-dct": (15, [30.879, 16.017, 57.273, 33.232]),
    "range-mark": (1, [22.723, 0.451, 0.568]),
    "song2002": (1, [22.723, 0.451, 0.568]),
    "vertex-ss": (1, [14.520, -1.164, 19.890]),
    "wang2011": (1, [7.996, 7.956, 0.532]),
}
"""Version of each scheme, and z after each attack."""


@pytest.mark.parametrize("name", READ)
def test_version_is_raised_when_a_scheme_reads_otherwise(name):
    marked, scheme = SCHEMES.build(name, {}).embed(ORIGINAL, 7)
    scheme = scheme if scheme.blind else scheme.with_original(ORIGINAL)
    version, z = READ[name]
    read = [scheme.score(attack(marked, np.random.default_rng(3)), 7).z for attack in ATTACKS[: len(z)]]
    assert (scheme.version, read) == (version, pytest.approx(z, abs=1.5 if name == "ohbuchi2002" else 0.01))
