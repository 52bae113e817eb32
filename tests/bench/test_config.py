"""Configs: strict, every fault in one go by line and path, in words that a user can act on."""

import re

import pytest

from wm3d.bench import load_experiment
from wm3d.errors import Wm3dError

GOOD = """\
name: good
trials: 5
cases:
  - meshes: [bunny]
    schemes:
      - {name: song2002, alpha: 1.3}
attacks:
  - {name: gaussian-noise, percent: 0.3}
"""

BAD = """\
nam: good
name: Two Words
seed: -1
seed: 3
trials: ten
block: 0
wrong_keys: 1.5
pf: [1e-6, 2, no]
unmarked: yes
cases:
  - meshes: []
    schemes:
      - {name: song2002, alhpa: 1.3, grid: [84], region: [2, 0, 81, 80], detector: {name: ggd-lrt, shape: x}}
      - {name: song, alpha: 1}
      - {alpha: 2}
      - song2002
  - meshes: bunny
    schemes:
      - {name: song2002, region: [10, 0, 80, 80]}
      - {name: song2002, miss: farwall, alpha: .inf, detector: {name: linaer}}
attacks:
  - name: gaussian-noise
    percnt: 0.6
    amplitude: rms
  - name: gausian-noise
  - {name: simplify, ratio: 2}
  -
title: 5
"""

FAULTS = """\
line 1, nam: unknown key; did you mean 'name'?
line 2, name: 'Two Words' must consist of lower-case letters, digits and hyphens.
line 3, seed: -1 must be at least 0.
line 4, seed: stands twice (first on line 3).
line 5, trials: 'ten' must be a whole number.
line 6, block: 0 must be at least 1.
line 7, wrong_keys: 1.5 must be a whole number.
line 8, pf[1]: 2 must be less than 1.
line 8, pf[2]: 'no' must be a number.
line 9, unmarked: 'yes' must be true or false.
line 11, cases[0].meshes: must have 1 or more items, not 0.
line 13, cases[0].schemes[0].alhpa: unknown key; did you mean 'alpha'?
line 13, cases[0].schemes[0].detector.shape: 'x' must be a number or 'ml'.
line 13, cases[0].schemes[0].grid[1]: is missing.
line 13, cases[0].schemes[0].region[2]: 81 must be a multiple of 8.
line 14, cases[0].schemes[1]: unknown name 'song'; did you mean 'song2002'?
line 15, cases[0].schemes[2]: needs a 'name'.
line 16, cases[0].schemes[3]: 'song2002' must be a mapping.
line 17, cases[1].meshes: 'bunny' must be a list.
line 19, cases[1].schemes[0]: the region's rows 10 to 89 and columns 0 to 79 do not fit a grid of 84 rows \
and 84 columns (a grid is N_v x N_u, columns first).
line 20, cases[1].schemes[1].alpha: inf must be finite.
line 20, cases[1].schemes[1].detector: unknown name 'linaer'; did you mean 'linear'?
line 20, cases[1].schemes[1].miss: 'farwall' must be 'far-wall' or 'exclude'.
line 23, attacks[0].percnt: unknown key; did you mean 'percent'?
line 24, attacks[0].amplitude: 'rms' must be 'rms-vector' or 'per-axis'.
line 25, attacks[1]: unknown name 'gausian-noise'; did you mean 'gaussian-noise'?
line 26, attacks[2].ratio: 2 must be at most 1.
line 27, attacks[3]: an empty value must be a mapping.
line 28, title: 5 must be text (quotes make text of a number).
"""


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "config.yaml"
    path.write_text(GOOD)
    return path


def faults(path, *overrides: str) -> list[str]:
    """Sentences of the error that a config raises, without the name of the file."""
    with pytest.raises(Wm3dError) as raised:
        load_experiment(path, list(overrides))
    first, *rest = str(raised.value).removeprefix(f"{path}: ").splitlines()
    if rest:
        assert first == f"{len(rest)} faults:"
    return [line.strip() for line in rest] or [first]


def test_all_faults_are_told_at_once_by_line_and_path(path):
    path.write_text(BAD)
    assert faults(path) == FAULTS.splitlines()


def test_what_is_missing_is_told(path):
    path.write_text("title: nothing else\n")
    assert faults(path) == [
        "line 1, attacks: are missing; list one or more, or name suites.",
        "line 1, cases: is missing.",
        "line 1, name: is missing.",
        "line 1, trials: is missing.",
    ]


def test_an_unknown_key_far_from_all_lists_the_known_ones(path):
    path.write_text(GOOD + "xyz: 1\n")
    (fault,) = faults(path)
    assert re.fullmatch(r"line 9, xyz: unknown key; known: name, title, seed, .*attacks\.", fault)


def test_overrides_change_values_deep_inside(path):
    experiment = load_experiment(
        path,
        [
            "trials=100",
            "pf=[1e-3, 1e-9]",
            "title=no",
            "cases.0.schemes.0.alpha=1e-1",
            "cases.0.schemes.0.detector={name: linear}",
            "attacks.0={name: clean}",
        ],
    )
    (scheme,) = experiment.cases[0].schemes
    assert (experiment.trials, experiment.pf, experiment.title) == (100, (1e-3, 1e-9), "no")
    assert (scheme.alpha, scheme.detector.name) == (0.1, "linear")
    assert [attack.name for attack in experiment.attacks] == ["clean"]


@pytest.mark.parametrize(
    ("override", "sentence"),
    [
        ("trials", "--set trials: must have the form path.to.field=value."),
        ("=3", "--set =3: must have the form path.to.field=value."),
        ("trials=", "--set trials=: an empty value must be a whole number."),
        ("trials=1e3", "--set trials=1e3: 1000.0 must be a whole number."),
        ("trials=[1",
         "--set trials=[1: line 1: is not valid YAML: expected ',' or ']', but got '<stream end>'."),
        ("trails=5", "--set trails=5: unknown key; did you mean 'trials'?"),
        ("trials.x=1", "--set trials.x=1: trials holds a single value."),
        ("case.0=1", "--set case.0=1: there is no 'case' in this config."),
        ("cases.1.meshes=[]",
         "--set cases.1.meshes=[]: there is no 1 in cases, a list of 1; indices count from 0."),
        ("attacks.1=1", "--set attacks.1=1: there is no 1 in attacks, a list of 1; indices count from 0."),
        ("cases.0.schemes.0.detector.shape=1",
         "--set cases.0.schemes.0.detector.shape=1: there is no 'detector' in cases[0].schemes[0]."),
        ("attacks.0.percnt=1", "--set attacks.0.percnt=1: unknown key; did you mean 'percent'?"),
        ("title=2020-13-45", "--set title=2020-13-45: line 1: is not valid YAML: '2020-13-45' is no "
         "timestamp, quote it if it is text."),
        ("title=&a [*a]",
         "--set title=&a [*a]: line 1, [0]: stands for itself, by an alias inside its anchor."),
        ("calibrate=50", "--set calibrate=50: 50 must be a mapping."),
        ("calibrate={metric: snr, value: 500}", "--set calibrate={metric: snr, value: 500}: a mark cannot be "
         "set to an SNR of 500 dB; it must be above 0 and at most 300 dB."),
        ("calibrate={[1]: 2}", "--set calibrate={[1]: 2}: line 1: the key must be a word."),
        ("seed=" + "1" * 5000, f"--set seed={'1' * 55}...{'1' * 17}: line 1: is not valid YAML: "
         f"'{'1' * 37}...{'1' * 38}' is no int, quote it if it is text."),
        ("title=" + "[" * 3000, f"--set title={'[' * 54}...{'[' * 17}: is nested too deeply."),
        (f"attacks.{'9' * 5000}=1", f"--set attacks.{'9' * 52}...{'9' * 15}=1: there is no "
         f"'{'9' * 37}...{'9' * 38}' in attacks, a list of 1; indices count from 0."),
        ("suites=[liris]", "--set suites=[liris]: there is no suite 'liris'; did you mean 'liris2010'?"),
    ],
)  # fmt: skip
def test_wrong_overrides_are_told_by_what_the_user_typed(path, override, sentence):
    assert faults(path, override) == [sentence]


def test_of_a_long_value_the_ends_are_told(path):
    path.write_text(GOOD.replace("trials: 5", f"trials: {'five' * 9999}"))
    (fault,) = faults(path)
    assert re.fullmatch(r"line 2, trials: 'five.{,80}five' must be a whole number\.", fault)


def test_an_override_mends_a_fault_of_the_file(path):
    path.write_text(GOOD.replace("trials: 5", "trials: five"))
    assert load_experiment(path, ["trials=5"]).trials == 5
