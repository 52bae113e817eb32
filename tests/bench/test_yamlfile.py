"""YAML 1.2 with lines: the scalars of JSON and no surprises, each key once, faults told by line."""

from pathlib import Path

import pytest

from wm3d.bench.yamlfile import read_yaml, write_yaml
from wm3d.errors import Wm3dError


@pytest.fixture
def yaml(tmp_path: Path):
    def read(text: str):
        path = tmp_path / "file.yaml"
        path.write_text(text)
        return read_yaml(path)

    return read


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-3", 1e-3),  # YAML 1.1 reads a string
        ("no", "no"),  # False
        ("on", "on"),  # True
        ("010", 10),  # 8
        ("1:30", "1:30"),  # 90
        ("100_000_000", 100_000_000),
        ("true", True),
        ("~", None),
        ("'5'", "5"),
        ("[84, 120]", [84, 120]),
    ],
)
def test_scalars_are_those_of_yaml_1_2(yaml, text, value):
    read = yaml(f"key: {text}").data["key"]
    assert read == value
    assert type(read) is type(value)


def test_every_value_knows_its_line(yaml):
    document = yaml("a: 1\nb:\n  - x: 1\n    y: 2\n  - {x: 3,\n     y: 4}\n")
    assert [
        document.line(path) for path in [("a",), ("b",), ("b", 0, "y"), ("b", 1, "x"), ("b", 1, "y")]
    ] == [
        1,
        2,
        4,
        5,
        6,
    ]
    assert document.line(("b", 1, "missing", 7)) == 5  # the nearest value around it
    assert document.where(("b", 1, "y")) == "line 6, b[1].y"


def test_a_key_that_stands_twice_keeps_its_first_value_and_is_a_fault(yaml):
    document = yaml("trials: 10\nseed: 1\ntrials: 20\nlist:\n  - {x: 1, x: 2}\n")
    assert document.data == {"trials": 10, "seed": 1, "list": [{"x": 1}]}
    assert document.faults == [
        (3, "line 3, trials: stands twice (first on line 1)."),
        (5, "line 5, list[0].x: stands twice (first on line 5)."),
    ]


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("5: a\n", "line 1: the key 5 must be a word."),
        ("a:\n  ? [b, c]\n  : 1\n", "line 2, a: the key must be a word."),
        ("a: &x [1, *x]\n", "line 1, a[1]: stands for itself, by an alias inside its anchor."),
    ],
)
def test_faults_that_leave_the_rest_readable_are_collected(yaml, text, fault):
    assert [sentence for _, sentence in yaml(text).faults] == [fault]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "must hold a mapping of keys to values, such as 'trials: 100'."),
        ("- a\n", "must hold a mapping of keys to values, such as 'trials: 100'."),
        ("a: [1, 2\nb: 3\n", "line 2: is not valid YAML: expected ',' or ']', but got ':'."),
        ("%YAML 1.9\n---\na: 1\n", "is not valid YAML: it asks for a version that there is not."),
        ("a: 1\n\tb: 3\n", "line 2: is not valid YAML: found character '\\t' that cannot start any token."),
        ("a: 1\n---\nb: 1\n", "line 2: is not valid YAML: expected a single document in the stream, but "
         "found another document."),
        ("a: 1\nb: !!python/object:os.system 3\n", "line 2: is not valid YAML: could not determine a "
         "constructor for the tag 'tag:yaml.org,2002:python/object:os.system'."),
    ],
)  # fmt: skip
def test_files_that_are_no_mapping_are_told_by_line(yaml, tmp_path, text, sentence):
    with pytest.raises(Wm3dError) as raised:
        yaml(text)
    assert str(raised.value) == f"{tmp_path / 'file.yaml'}: {sentence}"


@pytest.mark.parametrize(
    ("value", "problem"),
    [
        ("2020-13-45", "'2020-13-45' is no timestamp, quote it if it is text"),
        ("!!int abc", "'abc' is no int, quote it if it is text"),
        ("!!int ''", "'' is no int, quote it if it is text"),
        ("!!bool 7", "'7' is no bool, quote it if it is text"),
        ("1" * 5000, f"'{'1' * 37}...{'1' * 38}' is no int, quote it if it is text"),
        ("0x" + "f" * 5000, f"'0x{'f' * 35}...{'f' * 38}' is no int, quote it if it is text"),
    ],
)
def test_values_that_look_like_something_and_are_nothing_are_told_by_line(yaml, tmp_path, value, problem):
    for text in (f"a: 1\nb:\n  - {value}\n", f"a: 1\nb: 1\n? {value}\n: 1\n"):
        with pytest.raises(Wm3dError) as raised:
            yaml(text)
        assert str(raised.value) == f"{tmp_path / 'file.yaml'}: line 3: is not valid YAML: {problem}."


@pytest.mark.parametrize("depth", [250, 3000])  # a parser's limit comes first, or the interpreter's
def test_nesting_without_end_is_told(yaml, tmp_path, depth):
    with pytest.raises(Wm3dError) as raised:
        yaml("a: " + "[" * depth + "]" * depth)
    assert str(raised.value) == f"{tmp_path / 'file.yaml'}: is nested too deeply."


def test_files_that_are_no_text_are_told(tmp_path):
    with pytest.raises(Wm3dError, match=r"absent.yaml: cannot be read \(No such file or directory\)\.$"):
        read_yaml(tmp_path / "absent.yaml")
    (tmp_path / "noise.yaml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(Wm3dError, match=r"noise.yaml: is not a YAML file: it is not UTF-8 text\.$"):
        read_yaml(tmp_path / "noise.yaml")


def test_written_data_reads_back(yaml):
    data = {
        "b": [{"name": "a", "x": 1e-3}],
        "a": ["no", "1e-3", None, True, 1.0, 10, "öä", ""],
        "grid": [84, 120],
    }
    assert yaml(write_yaml(data)).data == data
    assert list(yaml(write_yaml(data)).data) == list(data)
