"""The key of a marked mesh: everything that detection needs, and never the original mesh."""

import json
import os
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from wm3d.errors import Wm3dError, shown
from wm3d.mesh import Mesh, Secret, write_whole
from wm3d.schemes.base import Scheme
from wm3d.schemes.registry import SCHEMES
from wm3d.stats import Score

FORMAT = "wm3d-key-1"

SAFE, DIGITS = 2**53, 78
"""Largest seed that stands in the file as a number, for many programs round larger ones. Those stand there as
text, of so many digits at most."""


@dataclass(frozen=True)
class Key:
    """A secret seed and the scheme, with its parameters, that it was embedded with.

    Attributes
    ----------
    scheme : Scheme
        For `song2002` this includes the grid and the corners of the region, the paper's second key.
    seed : int
        Non-negative; 256 bits at most.
    version : int, optional
        Version that the scheme had when the key was written, if it comes from a file that says so. Where the
        scheme has another now, it may read otherwise than it marked.
    """

    scheme: Scheme
    seed: int = field(repr=False)
    version: int | None = field(default=None, compare=False)

    def score(self, mesh: Mesh) -> Score:
        """Look for this key in a mesh.

        Raises
        ------
        Wm3dError
            If the scheme is not blind and the original is not at hand; see `with_original`.
        """
        return self.scheme.score(mesh, self.seed)

    def with_original(self, original: Mesh) -> "Key":
        """Return the key with the original mesh at hand, which a file of a key never holds."""
        return replace(self, scheme=self.scheme.with_original(original))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the key as JSON, for its owner's eyes only.

        Raises
        ------
        Wm3dError
            If the file cannot be written.
        """
        write_whole(path, self.encode())

    def encode(self) -> Secret:
        """Return the content of a key file."""
        content = {
            "format": FORMAT,
            "version": self.scheme.version if self.version is None else self.version,
            "seed": self.seed if self.seed <= SAFE else str(self.seed),
            "scheme": self.scheme.model_dump(mode="json"),
        }
        return Secret((json.dumps(content, indent=2) + "\n").encode())

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "Key":
        """Read a key that `save` wrote.

        Raises
        ------
        Wm3dError
            If the file cannot be read, is not a key, or its region does not fit its grid.
        """
        try:
            content = json.loads(Path(path).read_bytes())
        except OSError as error:
            raise Wm3dError(f"{path}: cannot be read ({error.strerror}).") from None
        except (ValueError, RecursionError):
            raise Wm3dError(f"{path}: is not a key file: it holds no JSON.") from None
        try:
            return cls._from_json(content)
        except Wm3dError as error:
            raise Wm3dError(f"{path}: {error}") from None

    @classmethod
    def _from_json(cls, content: Any) -> "Key":
        if not isinstance(content, dict) or content.get("format") != FORMAT:
            raise Wm3dError(f'is not a key file: "format" must be "{FORMAT}".')
        scheme, seed = content.get("scheme"), content.get("seed")
        if not isinstance(scheme, dict) or not isinstance(scheme.get("name"), str):
            raise Wm3dError('is not a complete key: "scheme" must hold the name and parameters of a scheme.')
        if isinstance(seed, str) and seed.isascii() and seed.isdigit() and len(seed) <= DIGITS:
            seed = int(seed)
        if not isinstance(seed, int) or isinstance(seed, bool) or not 0 <= seed < 1 << 256:
            raise Wm3dError(
                f'is not a complete key: "seed" is {shown(seed)}, not an integer from 0 to 2^256 − 1.'
            )
        version = content.get("version")
        if version is not None and (not isinstance(version, int) or isinstance(version, bool)):
            raise Wm3dError(f'is not a complete key: "version" is {shown(version)}, not an integer.')
        try:
            built = SCHEMES.build(scheme["name"], scheme)
        except Wm3dError as error:
            raise Wm3dError(f"{error}{_written_for(scheme['name'], version)}") from None
        try:
            _ = built.capacity  # which what embedding found out decides, too
        except Wm3dError as error:
            raise Wm3dError(f"is not a complete key: {error}") from None
        return cls(built, seed, version)


def _written_for(name: str, version: int | None) -> str:
    """Return the sentence that a key of another version of its scheme calls for, empty for others."""
    now = SCHEMES[name].version if name in SCHEMES else version
    if version in (None, now):
        return ""
    return (
        f" The key is of version {version} of its scheme, which is at {now} now; try the wm3d that wrote it."
    )
