"""The report: one file, nothing from outside, every table, honest words; made from rows alone."""

import base64
import json
import os
import re
import subprocess
import sys
from datetime import UTC, datetime
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from shapes import icosphere, tetrahedron

from wm3d.attacks import ATTACKS
from wm3d.bench import load_experiment, run_config, write_report
from wm3d.bench.columns import TRIALS
from wm3d.bench.curves import roc_figure
from wm3d.bench.manifest import manifest
from wm3d.bench.plan import plan
from wm3d.bench.readings import readings
from wm3d.bench.store import RunDirectory
from wm3d.bench.summary import print_summary
from wm3d.errors import Wm3dError
from wm3d.mesh import save_mesh
from wm3d.schemes import SCHEMES

CONFIG = """
name: made-up
title: A run that was <b>made up</b>
trials: 8
cases:
  - meshes: [{mesh}]
    schemes: [{{name: song2002}}]
attacks: [{{name: clean}}, {{name: similarity}}, {{name: gaussian-noise}}, {{name: simplify}}]
"""
Z = {"clean": 30.0, "similarity": 30.0, "gaussian-noise": 4.5, "simplify": -1.0}
"""Mean score after each attack: found, found, found at times at Pf = 1e-6 (z 4.75), lost."""


def made_up_run(
    path: Path, mesh: str = "bunny", scheme: str = "song2002", config: str = CONFIG
) -> RunDirectory:
    """Run directory with invented rows: eight keys an attack, spread by 1 around `Z`, two wrong keys each."""
    directory = RunDirectory(path)
    directory.create()
    directory.write_text("config.yaml", config.format(mesh=json.dumps(mesh)))
    experiment = load_experiment(path / "config.yaml")
    meshes = {mesh: tetrahedron()}
    cells = plan(experiment, meshes)
    for cell in cells:
        common = {column: "" if kind == "str" else 1 for column, kind in TRIALS.items()}
        common |= {"mesh": mesh, "scheme": scheme, "attack": cell.attack.label(), "log10_p_least": -1000}
        rows = []
        for trial in range(cell.start, cell.stop):
            z = Z[cell.attack.name] + (trial - 3.5) / 3.5
            rows.append(common | scored("H1", trial, z))
            rows += [common | scored("H0-wrong-key", 2 * trial + i, 0.2 * trial - i) for i in (0, 1)]
        directory.write_cell(cell.digest, pd.DataFrame(rows).astype(TRIALS))
    started = datetime(2002, 12, 9, tzinfo=UTC)
    directory.write_text("manifest.json", manifest(experiment, meshes, cells, started, 0))
    return directory


def scored(hypothesis: str, trial: int, z: float) -> dict[str, object]:
    # near enough to the Gaussian tail for z > 1
    return {"hypothesis": hypothesis, "trial": trial, "z": z, "log10_p": min(0.0, -0.25 * z * abs(z))}


class Page(HTMLParser):
    """Tags, attributes and text of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str]] = []
        self.words: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += [(name, value or "") for name, value in attrs]

    def handle_data(self, data: str) -> None:
        self.words.append(data)

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.words).split())


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> RunDirectory:
    directory = made_up_run(tmp_path_factory.mktemp("run"))
    write_report(directory.path)
    return directory


@pytest.fixture(scope="module")
def page(run: RunDirectory) -> Page:
    return Page((run.path / "report.html").read_text())


def test_report_refers_to_nothing_outside_itself(run: RunDirectory, page: Page) -> None:
    text = (run.path / "report.html").read_text()
    links = [
        value for name, value in page.attributes if name in ("src", "href", "xlink:href", "srcset", "data")
    ]
    assert len(links) > 10
    assert {link for link in links if not link.startswith(("#", "data:"))} == set()
    assert "@import" not in text
    assert re.findall(r"url\((?!#)", text) == []
    assert not {"link", "iframe", "object", "embed", "base"} & set(page.tags)
    ids = [value for name, value in page.attributes if name == "id"]
    assert {link[1:] for link in links if link.startswith("#")} <= set(ids)


def test_a_heat_map_is_drawn_from_four_attacks_on(run: RunDirectory, page: Page, tmp_path: Path) -> None:
    assert ("id", "heatmap") in page.attributes
    assert (run.path / "figures" / "heatmap.png").is_file()
    fewer = made_up_run(tmp_path, config=CONFIG.replace(", {{name: similarity}}", ""))
    write_report(fewer.path)
    assert [file.name for file in (tmp_path / "figures").glob("*.svg")] == ["roc.svg"]
    assert 'id="heatmap"' not in (tmp_path / "report.html").read_text()


def test_noise_is_told_in_its_common_unit_wherever_it_appears(run: RunDirectory, page: Page) -> None:
    name = "gaussian-noise 0.6 rms-vector (σ 0.35 %)"  # 0.6 / √3
    for figure in ("roc", "heatmap"):
        drawn = (run.path / "figures" / f"{figure}.svg").read_text()
        assert name in drawn
        assert "standard deviation of noise on each coordinate" in " ".join(drawn.split())
    table = pd.read_csv(run.path / "tables" / "detection.csv").set_index("attack")["sigma_percent"]
    assert table.dropna().to_dict() == {"gaussian-noise 0.6 rms-vector": pytest.approx(0.6 / 3**0.5)}
    assert "σ, %" in page.text


def test_noise_of_the_benchmark_depends_on_the_mesh(tmp_path: Path) -> None:
    config = tmp_path / "config.yaml"
    config.write_text(CONFIG.format(mesh="bunny") + "suites: [liris2010]\n")
    experiment = load_experiment(config)
    meshes = {"a": tetrahedron(), "b": icosphere(2)}
    told = json.loads(manifest(experiment, meshes, [], datetime.now(UTC), 0))["sigma_percent"]
    # on the sphere r̄ is 1 and the diagonal √12
    assert told["b"]["uniform-noise 0.3"] == pytest.approx(0.3 / 12**0.5 / 3**0.5, rel=0.02)
    assert told["a"]["uniform-noise 0.3"] != told["b"]["uniform-noise 0.3"]
    noise = {f"uniform-noise {a}" for a in (0.05, 0.1, 0.3, 0.5)}
    assert told["a"].keys() == noise | {"gaussian-noise 0.6 rms-vector"}


def test_every_table_can_be_had_from_the_report(run: RunDirectory, page: Page) -> None:
    held = {
        base64.b64decode(value.partition("base64,")[2]) for name, value in page.attributes if name == "href"
    }
    tables = list((run.path / "tables").glob("*.csv"))
    assert len(tables) >= 5
    assert {table.read_bytes() for table in tables} <= held


def test_summary_says_what_survives_with_intervals(page: Page) -> None:
    # 8 of 8: 95 % Clopper-Pearson from 0.025^(1/8) = 0.63; 3 of 8 of the noisy lie above the threshold
    assert (
        "At Pf = 10⁻⁶ the mark survives clean and similarity (Pd 1.00, 95 % interval 0.63–1.00 each)."
        in page.text
    )
    assert "It is lost to gaussian-noise 0.6 rms-vector (Pd 0.38, 95 % interval 0.09–0.76) and" in page.text
    assert "Stanford Computer Graphics Laboratory" in page.text


def test_names_are_text_and_never_markup(tmp_path: Path) -> None:
    hostile = '<script>alert(1)</script><img src=x onerror="alert(2)"> $\\frac{$ &amp;'
    directory = made_up_run(tmp_path, mesh=hostile, scheme=hostile)
    write_report(directory.path)
    page = Page((tmp_path / "report.html").read_text())
    assert page.tags.count("script") == 1
    assert "img" not in page.tags
    assert not [name for name, _ in page.attributes if name.startswith("on")]
    assert "".join(page.words).count(hostile) >= 5
    assert "<b>made up</b>" in page.text


def test_the_terminal_names_a_mesh_as_it_is_named(tmp_path: Path, capsys) -> None:
    for name in ("NA", "[red]bunny"):  # pandas reads "NA" as nothing, and brackets may be markup
        report = write_report(made_up_run(tmp_path, mesh=name).path)
        print_summary(report.tables, tmp_path, report.refused, report.pf)
        assert capsys.readouterr().out.startswith(f"{name}, song2002\n attack")


def test_no_report_is_written_while_a_run_writes_there(tmp_path: Path) -> None:
    directory = made_up_run(tmp_path)
    with directory.locked(), pytest.raises(Wm3dError, match="another run or report is writing here"):
        write_report(directory.path)
    assert not (tmp_path / "report.html").exists()


def test_page_and_terminal_say_why_a_scheme_marked_a_mesh_with_no_key(tmp_path: Path, capsys) -> None:
    save_mesh(icosphere(3), tmp_path / "ball.ply")
    config = tmp_path / "ball.yaml"
    config.write_text(
        f"name: ball\ncases: [{{meshes: [{tmp_path / 'ball.ply'}], schemes: [{{name: range-dct}}]}}]\n"
        "trials: 1\nattacks: [{name: clean}]\n"
    )
    run_config(config, out=tmp_path / "run", workers=1)
    said = capsys.readouterr().out
    text = Page((tmp_path / "run" / "report.html").read_text()).text
    assert "not marked: ball: looks the same" in said
    for words in (said, text):
        assert "ball: looks the same, or nearly, from all sides" in words
    assert "No mesh could be marked with range-dct" in text
    assert "No key of so few signs" not in text


def test_report_is_the_same_bytes_each_time(run: RunDirectory) -> None:
    files = ["report.html", "figures/roc.png", "figures/roc.svg", "tables/detection.csv"]
    first = [(run.path / file).read_bytes() for file in files]
    write_report(run.path)
    assert [(run.path / file).read_bytes() for file in files] == first


def test_roc_steps_exactly_at_the_p_values() -> None:
    log10_p = [-7.0, -3.5, -1.0, -20.0]
    rows = pd.DataFrame(
        {"mesh": "m", "scheme": "s", "attack": "a", "hypothesis": "H1", "z": 1.0, "log10_p": log10_p}
    )
    curve = roc_figure(rows, {}).axes[0].lines[0]
    np.testing.assert_array_equal(
        curve.get_xydata(), [[-8, 0.25], [-7, 0.5], [-3.5, 0.75], [-1, 1.0], [0, 1.0]]
    )
    assert curve.get_drawstyle() == "steps-post"


def test_attacks_always_survived_share_a_curve_where_colours_run_out() -> None:
    attacks = {f"harmless {k}": -20.0 for k in range(9)} | {"harsh": -2.0}
    rows = pd.DataFrame(
        {"mesh": "m", "scheme": "s", "attack": attack, "hypothesis": "H1", "z": 1.0, "log10_p": log10_p}
        for attack, log10_p in attacks.items()
    )
    (panel,) = roc_figure(rows, {}).axes
    labels = [text.get_text() for text in panel.get_legend().get_texts()]
    assert labels == ["9 attacks: Pd = 1 throughout", "harsh: d′ = 1.0", "chance: Pd = Pf"]


def test_every_reading_of_the_built_in_components_is_explained() -> None:
    components = [cls() for registry in (SCHEMES, ATTACKS) for cls in registry.values()]
    found = {reading.parameter: reading for reading in readings(components)}
    assert {"miss", "normalize", "shape", "amplitude", "simplifier"} <= found.keys()
    assert [name for name, reading in found.items() if len(reading.meaning) < 20] == []
    assert found["amplitude"].choices == ("rms-vector", "per-axis")
    assert found["amplitude"].used == ("rms-vector",)


def test_a_run_is_read_in_its_encoding_and_not_in_that_of_the_terminal(tmp_path: Path) -> None:
    directory = made_up_run(tmp_path, mesh="Größe")
    plain = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    program = f"from wm3d.bench import write_report; write_report({str(directory.path)!r})"
    subprocess.run([sys.executable, "-c", program], env=os.environ | plain, check=True)
    assert "Größe" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_directory_that_is_no_run_is_refused_in_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(Wm3dError, match=r"^[^\n]*is not the directory of a finished run[^\n]*\.$"):
        write_report(tmp_path / "nowhere")
