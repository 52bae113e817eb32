"""docs/attacks.md: every registered attack is defined there, with a picture that exists."""

import re
from pathlib import Path

import pytest

from wm3d.attacks import ATTACKS

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "attacks.md").read_text()
OURS = [name for name, cls in ATTACKS.items() if cls.__module__.startswith("wm3d.")]


@pytest.mark.parametrize("name", OURS)
def test_every_attack_is_named_and_pictured(name: str) -> None:
    assert f"`{name}`" in PAGE
    assert re.search(rf'src="attacks/{name}(-[a-z0-9-]+)?\.png"', PAGE)


def test_every_picture_of_the_page_is_there_and_none_is_left_over() -> None:
    shown = re.findall(r'src="attacks/([a-z0-9-]+\.png)"', PAGE)
    assert sorted(shown) == sorted(file.name for file in (DOCS / "attacks").iterdir())
