"""The page on plug-ins: its sessions run as printed, and its excerpts are those of the template."""

import doctest
import os
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "plugins.md"
TEMPLATE = ROOT / "examples" / "wm3d-plugin"


def test_every_session_of_the_page_runs_as_printed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(TEMPLATE / "src"))
    monkeypatch.delenv("WM3D_DATA", raising=False)  # the page means the bunny that comes with wm3d
    result = doctest.testfile(
        os.fspath(PAGE), module_relative=False, optionflags=doctest.ELLIPSIS, encoding="utf-8"
    )
    assert result.attempted > 20
    assert result.failed == 0


def test_every_excerpt_of_the_page_stands_in_the_template() -> None:
    sources = "\n".join(
        path.read_text() for path in TEMPLATE.rglob("*") if path.suffix in {".py", ".toml", ".yaml"}
    )
    blocks = re.findall(r"^```(?:python|toml|yaml)\n(.*?)^```", PAGE.read_text(), re.DOTALL | re.MULTILINE)
    excerpts = [block for block in blocks if not block.startswith(">>>")]
    assert len(excerpts) == 3
    assert [excerpt for excerpt in excerpts if excerpt not in sources] == []
