"""The robust variant of the paper's idea: a block-DCT mark in what an affine-invariant scanner sees."""

import math
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field

from wm3d.arrays import FloatArray
from wm3d.attacks import GaussianNoise, Similarity
from wm3d.errors import Wm3dError
from wm3d.imagemarks.blocks import AC, BLOCK, block_dct
from wm3d.imagemarks.fine_signs import LAYERS, FineSigns
from wm3d.imagemarks.shaped_dct import ShapedDct
from wm3d.mesh import Mesh, solid_moments, whole_surface
from wm3d.packing import packed
from wm3d.scanner.denoise import whitened_area
from wm3d.scanner.registration import Landmarks, Surface, Warp
from wm3d.schemes.base import Scheme
from wm3d.schemes.informed import change_of, informed_moves
from wm3d.schemes.settled import settled_moves
from wm3d.schemes.volume_host import Host, Layout, host_of
from wm3d.schemes.volume_reference import Reference
from wm3d.stats import RademacherSum, key_signs

TRIALS, TRIAL_NOISE = 3, 0.3
"""How often the mark of a symmetric solid must bear how much noise, in percent of the diagonal."""

MOST_ALPHA = 32.0
"""Bound of the strength: at 10 dB little of the mesh is left."""


class RangeDct(Scheme):
    """Block-DCT spread spectrum in the volume image, read in the affine frame that a key's moments fix.

    Where it differs from `Song2002`: the pose comes from the moments of the solid, so neither the density of
    the vertices nor a stretch nor a shear turns it; a cell holds the volume of the solid behind it and not
    the range of one ray; a surface crumpled by noise is smoothed before; vertices move along their normals,
    so that as many coefficients as can say their sign; amplitudes and detector follow the activity of each
    block; each coefficient says finer signs of the key as well, which rough attacks take away.

    Attributes
    ----------
    alpha : float
        Root mean square move of the vertices that a face uses, in percent of their root mean square distance
        from their mean: SNR = 40 dB − 20 dB lg α.
    blocks : int, optional
        8×8 blocks of the image, about, for meshes with vertices enough (`volume_host.FEWEST_VERTICES`); they
        are laid so that cells are square in the middle. By default 0.63 √vertices, 100 to 300.
    reference : Reference, optional
        What `embed` finds out of the mesh; detection needs it.
    """

    version: ClassVar[int] = 15

    name: Literal["range-dct"] = "range-dct"
    strength: ClassVar[str] = "alpha"

    alpha: Annotated[float, Field(gt=0, lt=MOST_ALPHA)] = 0.63
    blocks: Annotated[int, Field(ge=1, le=10_000)] | None = None
    reference: Annotated[Reference | None, Field(repr=False)] = None

    def label(self) -> str:
        """Return the legend text, which is that of the config: the reference differs from key to key."""
        bare = self.model_copy(update={"reference": None})
        return super(RangeDct, bare).label()

    @property
    def capacity(self) -> int:
        """63 signs of coefficients for each 8×8 block of the grid, and as many of each layer of fine ones."""
        columns, rows = self._known.grid
        return (1 + LAYERS) * (rows // BLOCK) * (columns // BLOCK) * AC

    def embed(self, mesh: Mesh, seed: int) -> tuple[Mesh, Self]:
        """Move the vertices along their normals so that the image says the key; see `Scheme.embed`."""
        host = host_of(mesh, self.blocks)
        if not host.mark.carries.any():
            raise Wm3dError(f"{mesh.name}: its volume image is flat, so no block can carry a mark.")
        surface = mesh.vertices[mesh.used]
        size = self.alpha / 100 * _rms(surface - surface.mean(axis=0))
        moves, fine = _moves(host, seed, size)
        marked = mesh.with_vertices(mesh.vertices + moves)

        reference = _reference(marked, host, seed, fine)
        if reference is None:
            raise self._unread(mesh, laid=host.mark.amplitude.shape[0])
        scheme = self.model_copy(update={"reference": reference})
        if host.ways > 1 and not scheme._tells_sides_apart(marked, seed):
            raise Wm3dError(
                f"{mesh.name}: looks the same, or nearly, from {host.ways} sides or all around, and a mark "
                f"of alpha {self.alpha:g} does not tell them apart; try a larger alpha, or another scheme."
            )
        return marked, scheme

    def _unread(self, mesh: Mesh, laid: int) -> Wm3dError:
        """Return the refusal of a mesh on which so many blocks were laid without use."""
        decibels = 40 - 20 * math.log10(self.alpha)
        return Wm3dError(
            f"{mesh.name}: the mark cannot be read even from the marked mesh; alpha {self.alpha:g}, about "
            f"{decibels:.4g} dB, is too faint or too strong, or the mesh has too few vertices, bounds no "
            "solid or is out of shape; try another strength"
            + (f", other blocks than {laid}," if laid > 1 or self.blocks else "")
            + " or a finer mesh (subdivide it)."
        )

    def _tells_sides_apart(self, marked: Mesh, seed: int) -> bool:
        """Tell whether a symmetric solid is found each time that noise was added and it was turned."""
        rng = np.random.default_rng(0)
        noise, turn = GaussianNoise(percent=TRIAL_NOISE), Similarity(min_scale=1, max_scale=1)
        try:
            return all(self.score(turn(noise(marked, rng), rng), seed).detected() for _ in range(TRIALS))
        except Wm3dError:
            return False

    def evidence(self, mesh: Mesh) -> RademacherSum:
        """Mend the surface, lay it where the marked one lay, read the volume image. See `Scheme.evidence`."""
        known = self._known
        mesh, vertices, tries = known.laid(whole_surface(mesh))
        layout = Layout(known.grid, known.hmin, known.height)
        image = layout.image(vertices, mesh)
        mark = ShapedDct.of(image.volumes, image.areas)
        expected = mark.evidence(known.strength).b, known.fine.expected(mark)
        return RademacherSum(0.0, np.concatenate(expected), tries)

    @property
    def _known(self) -> Reference:
        if self.reference is None:
            raise Wm3dError(
                "a range-dct scheme reads a mesh with the reference that its embedding returned; use that "
                "scheme, or its key."
            )
        return self.reference


def _moves(host: Host, seed: int, size: float) -> tuple[FloatArray, FineSigns]:
    """Return moves (n, 3) of a root mean square size that say a key, and where its fine signs lie."""
    signs = key_signs(seed, host.mark.amplitude.size)
    along = informed_moves(host, signs, size)
    fine = FineSigns.beside(host.mark, host.mark.strength_of(change_of(host, along), signs))
    fine_signs = key_signs(seed, signs.size + fine.capacity)[signs.size :]
    return host.moves(settled_moves(host, fine, fine_signs, along, size)), fine


def _reference(marked: Mesh, host: Host, seed: int, fine: FineSigns) -> Reference | None:
    """Measure what detection needs on the marked mesh; None if there the plain signs are not found."""
    frame, layout = host.frame, host.layout
    signs = key_signs(seed, host.mark.amplitude.size)
    seen = host.image_of(marked.vertices)
    survives = host.mark.strength_of(block_dct(seen.volumes - host.image.volumes)[:, 1:], signs)
    if survives <= 0 or not ShapedDct.of(seen.volumes, seen.areas).evidence(survives).score(signs).detected():
        return None
    marked = host.whole.with_vertices(marked.vertices)
    found = solid_moments(marked)
    surface = Surface.of(marked)
    pose = Warp.linear(surface.size * frame.matrix, frame.matrix @ (surface.middle - frame.centroid))
    return Reference(
        grid=layout.grid,
        hmin=layout.hmin,
        height=layout.height,
        moments=tuple(found.mapped(frame.matrix).entries().tolist()),
        offset=tuple((frame.matrix @ (found.centroid - frame.centroid)).tolist()),
        area=whitened_area(marked),
        landmarks=Landmarks.of(surface, pose).encode(),
        home=tuple(np.r_[frame.matrix.ravel(), -frame.matrix @ frame.centroid].tolist()),
        strength=survives,
        steps=packed(fine.step),
        ways=host.ways,
    )


def _rms(vectors: FloatArray) -> float:
    return float(np.sqrt((vectors**2).sum(axis=1).mean()))
