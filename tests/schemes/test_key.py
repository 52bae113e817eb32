"""Keys: everything that detection needs, through JSON and back, and every way in which a file is no key."""

import json

import numpy as np
import pytest
from shapes import blob

from wm3d import Key, Wm3dError, detect, embed
from wm3d.imagemarks import GgdLrt
from wm3d.schemes import Song2002

KEY = Key(
    Song2002(grid=(84, 120), region=(26, 4, 80, 72), alpha=0.9, miss="exclude", detector=GgdLrt(shape="ml")),
    seed=2**255 + 12345,
)
GOOD = {"format": "wm3d-key-1", "seed": 7, "scheme": {"name": "song2002"}}


def test_key_comes_back_from_its_file_and_finds_the_mark(tmp_path):
    KEY.save(tmp_path / "key.json")
    assert Key.load(tmp_path / "key.json") == KEY
    marked, _ = KEY.scheme.embed(blob(0, 5), KEY.seed)
    assert Key.load(tmp_path / "key.json").score(marked).z == KEY.score(marked).z > 10


@pytest.mark.parametrize("seed", [0, 2**53 - 1, 2**53 + 1, 2**256 - 1])
def test_seed_survives_a_program_that_knows_numbers_as_doubles_only(seed, tmp_path):
    Key(Song2002(), seed).save(tmp_path / "key.json")
    through = json.loads((tmp_path / "key.json").read_text(), parse_int=lambda digits: int(float(digits)))
    (tmp_path / "through.json").write_text(json.dumps(through))
    assert Key.load(tmp_path / "through.json").seed == seed


def test_key_file_keeps_the_version_that_its_scheme_had(tmp_path, monkeypatch):
    Key(Song2002(), 1).save(tmp_path / "key.json")
    monkeypatch.setattr(Song2002, "version", Song2002.version + 1)
    old = Key.load(tmp_path / "key.json")
    assert (old.version, old.scheme.version) == (Song2002.version - 1, Song2002.version)
    old.save(tmp_path / "again.json")
    assert Key.load(tmp_path / "again.json").version == old.version
    (tmp_path / "older.json").write_text(json.dumps(GOOD))
    assert Key.load(tmp_path / "older.json").version is None


def test_key_file_names_every_parameter_so_that_later_defaults_do_not_matter(tmp_path):
    Key(Song2002(), 1).save(tmp_path / "key.json")
    content = json.loads((tmp_path / "key.json").read_text())
    assert set(content["scheme"]) == set(Song2002.model_fields)
    assert content["scheme"]["detector"] == {"name": "ggd-lrt", "shape": 0.8}


def test_key_of_embed_is_all_that_detect_needs(tmp_path):
    mesh = blob(0, 5)
    marked, key = embed(mesh, seed=7, snr=50.0, grid=(40, 44), region=(2, 0, 40, 40))
    key.save(tmp_path / "key.json")
    result = detect(marked, Key.load(tmp_path / "key.json"))
    assert result.detected(1e-6)
    assert not detect(mesh, key).detected(1e-6)


def test_what_is_no_mesh_or_no_key_is_refused_with_the_way_to_one():
    with pytest.raises(Wm3dError, match=r"the mesh is a str, not a wm3d.Mesh; wm3d.load_mesh reads one"):
        embed("good.ply", seed=1)
    with pytest.raises(Wm3dError, match=r"the key is a str, not a wm3d.Key; wm3d.Key.load reads one"):
        detect(blob(0, 2), "key.json")


def test_secret_is_not_shown_where_a_key_is_printed():
    assert str(KEY.seed) not in repr(KEY)
    assert "landmarks" not in repr(embed(blob(0, 5), seed=1)[1])


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"", "is not a key file: it holds no JSON"),
        (b"\xff\xfe\x00", "is not a key file: it holds no JSON"),
        (b"[" * 100_000, "is not a key file: it holds no JSON"),
        (b"[1, 2]", 'is not a key file: "format" must be "wm3d-key-1"'),
        ({**GOOD, "version": "two"}, "\"version\" is 'two', not an integer"),
        ({**GOOD, "format": "wm3d-key-9"}, 'is not a key file: "format" must be "wm3d-key-1"'),
        ({**GOOD, "seed": -1}, '"seed" is -1, not an integer from 0 to'),
        ({**GOOD, "seed": 1 << 256}, "not an integer from 0 to"),
        ({**GOOD, "seed": 7.0}, '"seed" is 7.0, not an integer'),
        ({**GOOD, "seed": "7e3"}, "\"seed\" is '7e3', not an integer"),
        ({**GOOD, "seed": True}, '"seed" is True, not an integer'),
        ({"format": "wm3d-key-1", "scheme": {"name": "song2002"}}, '"seed" is None, not an integer'),
        ({**GOOD, "scheme": "song2002"}, '"scheme" must hold the name and parameters'),
        ({**GOOD, "scheme": {"name": ["song2002"]}}, '"scheme" must hold the name and parameters'),
        ({**GOOD, "scheme": {"name": "song2003"}}, "unknown scheme 'song2003'; did you mean 'song2002'?"),
        ({**GOOD, "scheme": {"name": "song2002", "aplha": 1}}, "unknown parameter 'aplha', did you"),
        ({**GOOD, "scheme": {"name": "song2002", "alpha": float("inf")}}, "alpha = inf: input should be"),
        ({**GOOD, "scheme": {"name": "song2002", "grid": [40, 40]}}, "do not fit a grid of 40 rows"),
        ({**GOOD, "scheme": {"name": "song2002", "grid": None}}, "grid = None: "),
        ({**GOOD, "version": 0, "scheme": {"name": "song2002", "aplha": 1}}, "try the wm3d that wrote it."),
        ({**GOOD, "scheme": {"name": "song2002", "detector": {"name": "best"}}}, "best"),
        ({**GOOD, "scheme": {"name": "range-dct"}}, "is not a complete key: a range-dct scheme reads"),
    ],
)  # fmt: skip
def test_malformed_key_is_refused_in_one_sentence(tmp_path, content, sentence):
    path = tmp_path / "key.json"
    path.write_bytes(content if isinstance(content, bytes) else json.dumps(content).encode())
    with pytest.raises(Wm3dError) as refusal:
        Key.load(path)
    assert str(refusal.value).startswith(f"{path}: ")
    assert sentence in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_missing_key_file_is_named(tmp_path):
    with pytest.raises(Wm3dError, match=r"none\.json: cannot be read \(No such file"):
        Key.load(tmp_path / "none.json")


def test_seed_is_random_unless_given():
    seeds = {embed(blob(0, 5), scheme="vertex-ss")[1].seed for _ in range(3)}
    assert len(seeds) == 3
    assert min(seeds) > 2**64  # once in 2^64 not so


@pytest.mark.parametrize("seed", [-1, 1 << 256, 1.5, "7"])
def test_embed_refuses_what_no_key_can_hold(seed):
    with pytest.raises(Wm3dError, match=r"the seed is .*; it must be an integer from 0 to"):
        embed(blob(0, 3), seed=seed)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"scheme": Song2002}, "the scheme is Song2002; give the name of a scheme, or one built of it."),
        ({"scheme": 5}, "the scheme is 5; give the name of a scheme, or one built of it."),
        ({"scheme": ""}, "unknown scheme ''; "),
        ({"snr": "abc"}, "the SNR is 'abc'; it must be a number of decibels."),
        ({"snr": [44]}, "the SNR is [44]; it must be a number of decibels."),
        ({"name": "song2002"}, "name='song2002': is no parameter; name a scheme by scheme=."),
        ({"scheme": Song2002(), "alpha": 2}, "parameters ['alpha'] go with the name of a scheme"),
    ],
)
def test_embed_refuses_wrong_arguments_in_one_sentence(arguments, sentence):
    with pytest.raises(Wm3dError) as refusal:
        embed(blob(0, 3), seed=1, **arguments)
    assert str(refusal.value).startswith(sentence)


def test_an_original_that_is_no_mesh_is_refused_even_where_none_is_needed():
    marked, key = embed(blob(0, 3), seed=1, scheme="song2002")
    with pytest.raises(Wm3dError, match=r"^the original is a str, not a wm3d\.Mesh; wm3d\.load_mesh reads"):
        detect(marked, key, original="blob.ply")


def test_embed_takes_the_integers_of_numpy(tmp_path):
    _, key = embed(blob(0, 3), seed=np.int64(7), scheme="song2002")
    key.save(tmp_path / "key.json")
    assert Key.load(tmp_path / "key.json") == key
