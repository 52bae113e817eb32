"""What several tests of the robust scheme start from."""

import pytest
from shapes import blob

from wm3d.schemes import SCHEMES


@pytest.fixture(scope="session")
def embedded():
    """A blob marked by range-dct with seed 1, and the scheme that reads it."""
    return SCHEMES.build("range-dct", {}).embed(blob(0, 5), 1)


@pytest.fixture(scope="session")
def evidence(embedded):
    marked, scheme = embedded
    return scheme.evidence(marked)
