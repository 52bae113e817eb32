"""Suites: every file holds valid attacks, a config takes them in, and the config as run names each itself."""

import re

import pytest

from wm3d.attacks import Clean, Float32, Weld
from wm3d.bench.config import load_experiment
from wm3d.bench.suites import FOLDER, load_suite, suite_names
from wm3d.bench.yamlfile import write_yaml
from wm3d.errors import Wm3dError

HEAD = "name: tiny\ntrials: 2\ncases: [{meshes: [bunny], schemes: [{name: song2002}]}]\n"


def written(folder, text):
    path = folder / "config.yaml"
    path.write_text(HEAD + text)
    return path


@pytest.mark.parametrize("name", suite_names())
def test_suite_starts_clean_repeats_nothing_and_leaves_no_parameter_unsaid(name):
    attacks = load_suite(name)
    assert attacks[0] == Clean()
    assert len(set(attacks)) == len(attacks)
    assert len({attack.label() for attack in attacks}) == len(attacks)  # told apart in a legend
    text = (FOLDER / f"{name}.yaml").read_text()
    assert text.startswith("# ")  # says where it is from


def test_liris_strengths_are_those_of_the_benchmark():
    strengths = {}
    for attack in load_suite("liris2010"):
        for field in ("percent", "iterations", "bits", "rule", "ratio"):
            if hasattr(attack, field):
                strengths.setdefault(attack.name, []).append(getattr(attack, field))
    assert strengths == {
        "uniform-noise": [0.05, 0.1, 0.3, 0.5],
        "laplacian-smoothing": [5, 10, 30, 50],
        "quantize": [11, 10, 9, 8, 7],
        "subdivide": ["midpoint", "sqrt3", "loop"],
        "simplify": [0.9, 0.7, 0.5, 0.3, 0.1, 0.05, 0.025],
        "crop": [10, 30, 50],
    }


def test_attacks_of_suites_follow_those_listed_each_once(tmp_path):
    attacks = load_experiment(
        written(tmp_path, "suites: [song2002, web]\nattacks: [{name: weld, percent: 0.5}, {name: float32}]\n")
    ).attacks
    assert attacks[:3] == (Weld(percent=0.5), Float32(), Clean())
    assert set(attacks[2:]) | {Float32()} == {*load_suite("song2002"), *load_suite("web")}
    assert len(set(attacks)) == len(attacks)


def test_config_as_run_names_every_attack_and_no_suite(tmp_path):
    experiment = load_experiment(written(tmp_path, "suites: [liris2010]\n"))
    as_run = tmp_path / "as-run.yaml"
    as_run.write_text(write_yaml(experiment.model_dump(mode="json")))
    assert re.search(r"^suites", as_run.read_text(), re.MULTILINE) is None
    assert load_experiment(as_run).attacks == experiment.attacks == load_suite("liris2010")


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (
            "suites: [liris2011]\n",
            "line 4, suites[0]: there is no suite 'liris2011'; did you mean",
        ),
        (
            "suites: [../secret]\n",
            "line 4, suites[0]: there is no suite '../secret'; known: hostile",
        ),
        ("attacks: []\n", "line 4, attacks: are missing; list one or more, or name suites."),
        ("", "attacks: are missing; list one or more, or name suites."),
        ("attacks: [{name: chain}]\n", "line 4, attacks: hold a chain of none; name the attacks of a chain"),
        (
            "attacks:\n  - name: chain\n    then:\n      - { name: weld, precent: 1 }\n",
            "line 7, attacks[0].then[0].precent: unknown key; did you mean 'percent'?",
        ),
        (
            "attacks:\n  - name: chain\n    then: [{ name: chain }]\n",
            "attacks[0].then[0]: unknown name 'chain'",
        ),
    ],
)
def test_faults_are_named_with_their_line(tmp_path, text, sentence):
    with pytest.raises(Wm3dError) as refusal:
        load_experiment(written(tmp_path, text))
    assert sentence in str(refusal.value)
