"""Bad input: exit status 2, one sentence that names the file and the problem, and no file left behind."""

import os
import re
import shlex
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

Run = Callable[..., Any]

EMBED = "embed {files}/good.ply {out}/marked.ply --key {out}/key.json"
DETECT = "detect {files}/marked.ply --key {files}/good.json"
ATTACK = "attack {files}/good.ply {out}/attacked.ply"
SCAN = "scan {files}/good.ply {out}/image.npy"

#: File, and what is to be said about it by every command that reads a mesh.
UNREADABLE = {
    "missing.ply": "no such file",
    "empty.ply": "is empty",
    "text.ply": "cannot be read as PLY",
    "text.obj": "cannot be read as OBJ",
    "cut.ply": "cannot be read as PLY",
    "mesh.xyz": "no mesh format",
    "folder.ply": "is a folder",
    "cloud.off": "has no faces",
    "nan.off": "vertex 1 has a coordinate that is NaN",
    "dangling.off": "names vertex 7",
    "point.off": "all vertices lie in one point",
}
#: Meshes without a range image.
UNSCANNABLE = {
    "sphere.ply": "no unique axes",
    "line.off": "in a plane",
    "triangle.off": "in a plane",
    "sheet.off": "in a plane",
}
BAD_KEYS = {
    "missing": "cannot be read",
    "folder": "cannot be read",
    "empty": "holds no JSON",
    "text": "holds no JSON",
    "binary": "holds no JSON",
    "deep": "holds no JSON",
    "list": '"format"',
    "other-format": '"format"',
    "no-seed": '"seed"',
    "huge-seed": '"seed"',
    "text-seed": '"seed"',
    "other-grid": "do not fit a grid",
    "odd-region": "multiple of 8",
    "unknown-scheme": "did you mean 'song2002'",
    "unknown-parameter": "did you mean 'alpha'",
    "unknown-detector": "unknown name 'gdd-lrt'",
    "nan-alpha": "alpha",
}


def _table() -> list[tuple[str, str, str]]:
    """Command line, the file or option that the sentence must name, and words that it must hold."""
    rows = []
    for file, words in (UNREADABLE | UNSCANNABLE).items():
        rows += [
            (
                line.replace("good.ply", file).replace("marked.ply", file, 1 if "detect" in line else 0),
                file,
                words,
            )
            for line in (EMBED, DETECT, SCAN)
        ]
    rows += [(f"{ATTACK.replace('good.ply', file)} clean", file, words) for file, words in UNREADABLE.items()]
    rows += [
        (DETECT.replace("good.json", f"{key}.json"), f"{key}.json", words) for key, words in BAD_KEYS.items()
    ]
    return [
        *rows,
        (f"{EMBED} --region 8,0,80,80", "region", "do not fit a grid"),
        (f"{EMBED} --region 2,0,80,81", "region", "multiple of 8"),
        (f"{EMBED} --region 2,0,80,0", "region", "greater than or equal to 8"),
        (f"{EMBED} --region 2,0,80", "--region", "U0,V0,NU,NV"),
        (f"{EMBED} --grid 84", "--grid", "NVxNU"),
        (f"{EMBED} --grid 0x84", "grid", "greater than or equal to 1"),
        (f"{EMBED} --grid 99999x84", "grid", "less than or equal to 32768"),
        (f"{EMBED} --scheme song2003", "song2003", "did you mean 'song2002'"),
        (f"{EMBED} --alpha -1", "alpha", "greater than 0"),
        (f"{EMBED} --alpha 1e99", "alpha", "less than 32"),
        (f"{EMBED} --alpha nan", "alpha", "finite"),
        (f"{EMBED} --alpha 1 --snr 40", "alpha and --snr", "give one"),
        (f"{EMBED} --alpha 1 alpha=2", "alpha", "twice"),
        (f"{EMBED} --snr nan", "good.ply", "SNR"),
        (f"{EMBED} --snr 0", "good.ply", "an SNR of 0 dB; it must be above 0"),
        (f"{EMBED} --snr 1e9", "good.ply", "SNR"),
        (f"{EMBED} --snr -1e9", "good.ply", "SNR"),
        (f"{EMBED} --seed -1", "seed", "from 0 to"),
        (f"{EMBED} --seed {1 << 256}", "seed", "2^256"),
        (f"{EMBED} --seed seven", "--seed", "integer"),
        (f"{EMBED} miss=fill", "miss", "far-wall"),
        (f"{EMBED} alhpa=1", "alhpa", "did you mean 'alpha'"),
        (f"{EMBED} seed=1", "seed", "unknown parameter"),
        (f"{EMBED} name=clean", "name=clean", "param=value"),
        (f"{EMBED} mark.alpha=6", "mark.alpha=6", "'mark={name: ..., alpha: 6}'"),
        (f"{DETECT} --pf 0", "false-alarm probability", "0.0"),
        (f"{DETECT} --pf 1.5", "false-alarm probability", "1.5"),
        (f"{DETECT} --pf nan", "false-alarm probability", "nan"),
        (f"{DETECT} --pf small", "--pf", "number"),
        ("attack crop {files}/good.ply {out}/attacked.ply", "attacked.ply", "the order is IN OUT NAME"),
        (f"{ATTACK} gausian-noise", "gausian-noise", "did you mean 'gaussian-noise'"),
        (f"{ATTACK} gaussian-noise sigma=1", "sigma", "known: percent, amplitude"),
        (f"{ATTACK} gaussian-noise percent=-1", "percent", "greater than or equal to 0"),
        (f"{ATTACK} gaussian-noise percent=.nan", "percent", "finite"),
        (f"{ATTACK} gaussian-noise percent=1e300", "good.ply", "coordinate"),
        (f"{ATTACK} gaussian-noise percent=", "percent", "number"),
        (f"{ATTACK} gaussian-noise percent", "percent", "param=value"),
        (f"{ATTACK} chain", "chain: chains no attacks", "then=[{name: mirror}"),
        (f"{ATTACK} gaussian-noise percent=1e308", "gaussian-noise: ", "rescale it"),
        (f"{ATTACK} gaussian-noise percent=[1", "percent", "YAML"),
        (f"{ATTACK} gaussian-noise percent=2020-13-45", "percent=2020-13-45", "is no timestamp"),
        (f"{ATTACK} gaussian-noise percent={'[' * 3000}", "percent=[", "nested too deeply"),
        (f"{ATTACK} gaussian-noise percent={'9' * 5000}", "percent=9", "is no int"),
        (f"{ATTACK} gaussian-noise percent=1 percent=2", "percent", "twice"),
        (f"{ATTACK} gaussian-noise --seed -1", "--seed", "greater than or equal to 0"),
        (f"{ATTACK} similarity max_scale=0.01", "max_scale", "above"),
        (f"{ATTACK} simplify ratio=2", "ratio", "less than or equal to 1"),
        (f"{SCAN} --grid 0x0", "grid of 0x0", "between 1x1"),
        (f"{SCAN} --pose face-pca", "--pose", "vertex-pca"),
        ("scan {files}/good.ply {out}/image.jpg", "image.jpg", ".png or .npy"),
        ("scan {files}/good.ply {out}/image", "image", ".png or .npy"),
        ("list colours", "KIND", "schemes"),
        ("data path nobody", "nobody", "neither a dataset nor a mesh file"),
        ("data fetch bunni", "bunni", "did you mean 'bunny'"),
        ("report {files}", "files", ""),
        ("run {files}/missing.yaml", "missing.yaml", "cannot be read"),
        ("run {files}/good.ply --out {out}/run", "good.ply", "YAML"),
        ("embed {files}/good.ply {out}/marked.ply", "--key", "Missing option"),
        ("embed", "IN", "Missing argument"),
        ("imbed", "imbed", "No such command"),
        ("scan {files}/good.ply {out}/image.png --colour", "--colour", "No such option"),
    ]


def _unwritable() -> list[tuple[str, str, str]]:
    """Targets that nobody can write, root included."""
    targets = {
        "{out}/nowhere/{file}": "does not exist",
        "{files}/good.ply/{file}": "is not a folder",
        "{files}/folder{ending}": "is a folder",
        "/proc/{file}": "cannot be written",
    }
    rows = []
    for target, words in targets.items():
        mesh = target.replace("{file}", "marked.ply").replace("{ending}", ".ply")
        key = target.replace("{file}", "key.json").replace("{ending}", ".json")
        rows += [
            (f"embed {{files}}/good.ply {mesh} --key {{out}}/key.json", mesh, words),
            (f"embed {{files}}/good.ply {{out}}/marked.ply --key {key}", key, words),
            (f"attack {{files}}/good.ply {mesh} clean", mesh, words),
        ]
    return [
        *rows,
        ("scan {files}/good.ply {out}/nowhere/image.npy", "nowhere/image.npy", "does not exist"),
        ("scan {files}/good.ply /proc/image.png", "/proc/image.png", "cannot be written"),
        ("embed {files}/good.ply {out}/marked.xyz --key {out}/key.json", "marked.xyz", "no mesh format"),
        ("embed {files}/good.ply {out}/marked.ply --key {out}/marked.ply", "marked.ply", "name of its own"),
        ("embed {files}/good.ply {out}/marked.ply --key {files}/good.ply", "good.ply", "name of its own"),
        ("embed {files}/good.ply {files}/good.ply --key {out}/key.json", "good.ply", "is the original"),
        ("attack {files}/good.ply {files}/good.ply clean", "good.ply", "is the original"),
        ("embed {files}/good.ply {out}/marked.ply --key /dev/null", "/dev/null", "is a device"),
    ]


@pytest.mark.parametrize(("line", "named", "words"), [*_table(), *_unwritable()], ids=lambda text: text)
def test_one_sentence_and_no_file(
    line: str, named: str, words: str, wm3d: Run, files: Path, out: Path
) -> None:
    if "/proc/" in line and not Path("/proc").is_dir():
        pytest.skip("needs /proc, a folder that even root cannot write to")
    before = _contents(files)
    outcome = wm3d(*(word.format(files=files, out=out) for word in line.split()))
    assert outcome.status == 2
    assert outcome.stdout == ""
    _check_sentence(outcome.stderr, named.format(files=files, out=out), words)
    assert list(out.iterdir()) == []
    assert _contents(files) == before


@pytest.mark.parametrize(
    ("line", "named", "words"),
    [
        ("embed good {files}/good.ply --key {out}/key.json", "good.ply", "is the original"),
        ("embed good {out}/marked.ply --key {files}/good.ply", "good.ply", "name of its own"),
        ("attack good {files}/good.ply clean", "good.ply", "is the original"),
        ("embed {files}/good.ply {out}/link.ply --key {out}/key.json", "link.ply", "is the original"),
        ("embed {files}/good.ply {out}/marked.ply --key {out}/link.ply", "link.ply", "name of its own"),
        ("scan {files}/good.ply {out}/link.png", "link.png", "is the original"),
    ],
)
def test_the_original_is_known_by_its_dataset_name_and_through_links(
    line: str, named: str, words: str, wm3d: Run, files: Path, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("WM3D_DATA", str(files))
    (out / "link.ply").hardlink_to(files / "good.ply")
    (out / "link.png").symlink_to(files / "good.ply")
    before = _contents(files), _contents(out)
    outcome = wm3d(*(word.format(files=files, out=out) for word in line.split()))
    assert outcome.status == 2
    _check_sentence(outcome.stderr, named, words)
    assert (_contents(files), _contents(out)) == before


def test_a_key_that_cannot_be_put_in_place_leaves_both_files_as_they_were(
    wm3d: Run, files: Path, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    arguments = ("embed", files / "good.ply", out / "marked.ply", "--key", out / "key.json", "--seed", "1")
    replace = Path.replace

    def refuse_key(self: Path, target: Path) -> Path:
        if target.name == "key.json":
            raise PermissionError(1, "Operation not permitted")
        return replace(self, target)

    monkeypatch.setattr(Path, "replace", refuse_key)
    for before in ({}, {"marked.ply": b"an older mesh", "key.json": b"an older key"}):
        for name, content in before.items():
            (out / name).write_bytes(content)
        outcome = wm3d(*arguments)
        assert outcome.status == 2
        _check_sentence(outcome.stderr, str(out / "key.json"), "Operation not permitted")
        assert _contents(out) == before


@pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() == 0, reason="file permissions do not bind root"
)
def test_files_without_permission(wm3d: Run, files: Path, out: Path) -> None:
    secret = out / "secret.ply"
    secret.write_bytes((files / "good.ply").read_bytes())
    secret.chmod(0)
    _check_sentence(wm3d("scan", secret, out / "image.npy").stderr, str(secret), "permission denied")
    out.chmod(0o500)
    try:
        _check_sentence(
            wm3d("attack", files / "good.ply", out / "a.ply", "clean").stderr,
            str(out / "a.ply"),
            "Permission",
        )
    finally:
        out.chmod(0o700)


PROCESS = [sys.executable, "-c", "import sys; from wm3d.cli import main; sys.exit(main())"]


@pytest.mark.parametrize(
    ("line", "named", "words"),
    [
        (DETECT.replace("marked.ply", "sphere.ply"), "sphere.ply", "no unique axes"),
        (f"{EMBED} --region 8,0,80,80", "region", "do not fit a grid"),
        (f"{ATTACK} gaussian-noise percent=1e300", "good.ply", "coordinate"),
        ("detect", "MESH", "Missing argument"),
    ],
)
def test_as_a_process(line: str, named: str, words: str, files: Path, out: Path) -> None:
    words_of_line = [word.format(files=files, out=out) for word in line.split()]
    done = subprocess.run([*PROCESS, *words_of_line], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stdout == ""
    _check_sentence(done.stderr, named, words)
    assert list(out.iterdir()) == []


FULL = pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")


@pytest.mark.parametrize(
    ("mesh", "redirection", "status"),
    [
        ("marked.ply", "| true", 141),
        ("marked.ply", "2>&-", 0),
        pytest.param("marked.ply", ">/dev/full 2>&1", 2, marks=FULL),
        pytest.param("no.ply", "2>/dev/full", 2, marks=FULL),
    ],
)
def test_output_that_cannot_be_written_is_no_answer(
    mesh: str, redirection: str, status: int, files: Path
) -> None:
    detect = shlex.join([*PROCESS, "detect", str(files / mesh), "--key", str(files / "good.json")])
    script = f"set -o pipefail; {detect} {redirection}"
    assert subprocess.run(["bash", "-c", script], capture_output=True, check=False).returncode == status


def test_a_bug_is_dressed_up_neither_as_bad_input_nor_as_no_mark(
    wm3d: Run, monkeypatch: pytest.MonkeyPatch, files: Path
) -> None:
    def broken(*_: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr("wm3d.schemes.Key.score", broken)
    outcome = wm3d("detect", files / "good.ply", "--key", files / "good.json")
    assert outcome.status == 70
    assert outcome.stdout == ""
    assert outcome.stderr.startswith("Traceback")
    assert outcome.stderr.endswith("ZeroDivisionError\n")
    assert "; 70 an error in wm3d " in " ".join(wm3d("--help").stdout.split())


def _check_sentence(stderr: str, named: str, words: str) -> None:
    sentence = stderr.removesuffix("\n")
    assert sentence.startswith("wm3d: ")
    assert sentence.endswith((".", "?"))
    assert "\n" not in sentence
    assert not re.search(r"[.?!] +[A-Z]", sentence), "more than one sentence"
    assert "Traceback" not in sentence
    assert named in sentence
    assert words in sentence


def _contents(folder: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in folder.iterdir() if file.is_file()}
