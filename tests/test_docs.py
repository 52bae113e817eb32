"""Pages in docs: sessions run as printed, excerpts are those of the template, every field has its line."""

import doctest
import os
import re
from pathlib import Path

import pandas as pd
import pytest

from wm3d.bench.columns import TRIALS
from wm3d.bench.config import Experiment, load_experiment
from wm3d.bench.tables import detection

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


def test_page_on_configs_names_every_field_with_its_default_and_every_column(tmp_path: Path) -> None:
    page = (ROOT / "docs" / "configs.md").read_text()
    for name, field in Experiment.model_fields.items():
        (line,) = re.findall(rf"^\| `{name}` \| (.*?) ?\|", page, re.MULTILINE)
        default = field.default
        if field.is_required():
            assert line == ""
        elif isinstance(default, tuple):
            assert line == (", ".join(f"{value:.0e}".replace("e-0", "e-") for value in default) or "none")
        else:
            assert line == (str(default).lower() or "empty")
    for column in detection(pd.DataFrame(columns=list(TRIALS)).astype(TRIALS), (1e-6,)).columns:
        assert f"`{column}`" in page, column
    (example,) = re.findall(r"^```yaml\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
    (tmp_path / "example.yaml").write_text(example)
    assert load_experiment(tmp_path / "example.yaml").trials == 20
