"""The registry of named meshes: where each comes from, its size, its credit line and its terms."""

from dataclasses import dataclass

from wm3d.mesh.recipes import RECIPES, Recipe
from wm3d.mesh.sources import Bundled, Download

STANFORD = "Stanford Computer Graphics Laboratory, The Stanford 3D Scanning Repository"
STANFORD_TERMS = (
    "free for research, mirroring and redistribution with credit; no commercial use without permission"
)
_SCANS = "https://graphics.stanford.edu/pub/3Dscanrep"


@dataclass(frozen=True)
class Dataset:
    """An entry of the registry.

    Attributes
    ----------
    source : Bundled, Download or Recipe
        How the mesh is had.
    vertices, faces : int, optional
        Their numbers, where known before the mesh is read.
    credit : str, optional
        Line that a caption must carry where a figure shows the mesh.
    terms : str, optional
        What its owner allows.
    """

    source: Bundled | Download | Recipe
    vertices: int | None = None
    faces: int | None = None
    credit: str | None = None
    terms: str | None = None


DATASETS: dict[str, Dataset] = {
    "bunny": Dataset(
        Bundled(
            package="pymeshlab",
            file="tests/sample_meshes/bunny.obj",
            sha256="37574b0008f96cd098bac287d6b77ffea7b1e79df93daf7054680e0e93395857",
        ),
        vertices=28088,
        faces=56172,
        credit=STANFORD,
        terms=STANFORD_TERMS,
    ),
    "bunny-zipper": Dataset(
        Download(
            f"{_SCANS}/bunny.tar.gz",
            sha256="a5720bd96d158df403d153381b8411a727a1d73cff2f33dc9b212d6f75455b84",
            member="bunny/reconstruction/bun_zipper.ply",
            member_sha256="b1acc63bece78444aa2e15bdcc72371a201279b98c6f5d4b74c993d02f0566fe",
        ),
        vertices=35947,
        faces=69451,
        credit=STANFORD,
        terms=STANFORD_TERMS,
    ),
    "happy-buddha": Dataset(
        Download(
            f"{_SCANS}/happy/happy_recon.tar.gz",
            sha256="409cd294efbfd8244e15a382b95a9423f153b7776e736c9b09f19ec9d3c10ed0",
            member="happy_recon/happy_vrip.ply",
            member_sha256="2283371216d748a08376a3c88698e283cc8f18d10ced348d6d133051bcf217ab",
        ),
        vertices=543652,
        faces=1087716,
        credit=STANFORD,
        terms=f"{STANFORD_TERMS}; renderings to be kept in good taste",
    ),
    "dragon": Dataset(
        Download(
            f"{_SCANS}/dragon/dragon_recon.tar.gz",
            sha256="74ac1d90989c9b1732edee82d57e9ce71452144cf4355f108d8c9c616d28d02f",
            member="dragon_recon/dragon_vrip.ply",
            member_sha256="fea87ff48f2aba22fb53e7b67c3ff3f7b8c2a3b3a0653af62c48bba67c6d5744",
        ),
        vertices=437645,
        faces=871414,
        credit=STANFORD,
        terms=STANFORD_TERMS,
    ),
    "armadillo": Dataset(
        Download(
            f"{_SCANS}/armadillo/Armadillo.ply.gz",
            sha256="8b9b56cc36e66d54429b1e1e75bd89e833645bfe0dc7c1afd1205877a7356a3f",
        ),
        vertices=172974,
        faces=345944,
        credit=STANFORD,
        terms=STANFORD_TERMS,
    ),
    "rabbit": Dataset(
        Download(
            "https://raw.githubusercontent.com/kmammou/v-hacd-data/"
            "8c82db684aac12483ae80e5bd1b9a68450e8aff0/data/rabbit.off",
            git_blob="fc0041ac2e2588fcc8f28f7332ad60075b2b62e3",
        ),
        credit="Cyberware, by way of the V-HACD data",
    ),
    "happy-buddha-300k": Dataset(
        RECIPES["happy-buddha-300k"],
        faces=300074,
        credit=STANFORD,
        terms=f"{STANFORD_TERMS}; renderings to be kept in good taste",
    ),
}
