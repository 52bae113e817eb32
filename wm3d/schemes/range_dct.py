"""The robust variant of the paper's idea: a block-DCT mark in what an affine-invariant scanner sees."""

import math
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from wm3d.arrays import FloatArray
from wm3d.attacks import GaussianNoise, Similarity
from wm3d.errors import NoSolidError, Wm3dError
from wm3d.imagemarks.blocks import AC, BLOCK, block_dct
from wm3d.imagemarks.fine_signs import LAYERS, FineSigns
from wm3d.imagemarks.shaped_dct import ShapedDct
from wm3d.mesh import Mesh, SolidMoments, solid_moments, whole_surface
from wm3d.mesh.solid import ENTRIES
from wm3d.packing import packed, unpacked
from wm3d.scanner.affine import MOST_WAYS, AffineFrame, recognized
from wm3d.scanner.denoise import denoised, whitened_area
from wm3d.scanner.registration import CLEAR, Landmarks, Surface, Warp, nearest, registered
from wm3d.scanner.scan import MAX_GRID
from wm3d.schemes.base import Scheme
from wm3d.schemes.informed import change_of, informed_moves
from wm3d.schemes.settled import settled_moves
from wm3d.schemes.volume_host import Host, Layout, host_of
from wm3d.stats import RademacherSum, key_signs

FARTHEST = 1e60
"""Bound of the entries of a stored pose, and 1 over it of its matrix: squares of the places that it leads to
and comes from are finite, whatever the unit of the mesh."""

TRIALS, TRIAL_NOISE = 3, 0.3
"""How often the mark of a symmetric solid must bear how much noise, in percent of the diagonal."""

MOST_ALPHA = 32.0
"""Bound of the strength: at 10 dB little of the mesh is left, and faces that span all of it take minutes."""

GridSize = Annotated[int, Field(ge=BLOCK, le=MAX_GRID, multiple_of=BLOCK)]
Entry = Annotated[float, Field(ge=-FARTHEST, le=FARTHEST)]


def _checked_landmarks(text: str) -> str:
    Landmarks.decode(text)
    return text


def _checked_steps(text: str) -> str:
    if (unpacked(text, 1, "steps") < 0).any():
        raise ValueError("steps must not be negative")
    return text


def _checked_home(home: tuple[float, ...]) -> tuple[float, ...]:
    if max(map(abs, home[:9])) < 1 / FARTHEST:
        raise ValueError(f"a pose must not shrink a mesh by more than {FARTHEST:g}")
    return home


class Reference(BaseModel):
    """What the embedder works out for a mesh and detection needs; part of the key.

    Attributes
    ----------
    grid : (N_v, N_u)
        Columns around and rows along the axis.
    hmin, height : float
        Lower end and height of the cylinder, from the solid's centroid, in the unit of the frame.
    moments : (31,) tuple of float
        `SolidMoments.entries` of the marked solid in the frame of the scanner.
    offset : (3,) tuple of float
        Where the marked solid's centroid lies in that frame.
    area : float
        `whitened_area` of the marked mesh.
    landmarks : str
        `Landmarks` of the marked mesh, in that frame.
    home : (12,) tuple of float
        Matrix and shift of the linear map that took the marked mesh into that frame.
    strength : float
        Amplitude of the mark that can be read back, in the unit of the frame.
    steps : str
        `FineSigns.step` of each block, in the cubed unit of the frame.
    ways : int
        In how many ways the solid can be laid on itself, or nearly; more than 1 for a symmetric one.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    grid: tuple[GridSize, GridSize]
    hmin: float
    height: Annotated[float, Field(gt=0)]
    moments: Annotated[tuple[float, ...], Field(min_length=ENTRIES, max_length=ENTRIES)]
    offset: tuple[Entry, Entry, Entry]
    area: Annotated[float, Field(gt=0)]
    landmarks: Annotated[str, AfterValidator(_checked_landmarks)]
    home: Annotated[tuple[Entry, ...], Field(min_length=12, max_length=12), AfterValidator(_checked_home)]
    strength: Annotated[float, Field(gt=0)]
    steps: Annotated[str, AfterValidator(_checked_steps)]
    ways: Annotated[int, Field(ge=1, le=MOST_WAYS)] = 1

    @model_validator(mode="after")
    def _one_step_a_block(self) -> Self:
        blocks, steps = self.grid[0] * self.grid[1] // BLOCK**2, len(self.fine.step)
        if steps != blocks:
            raise ValueError(
                f"a grid of {self.grid[0]}×{self.grid[1]} has {blocks} blocks, but {steps} steps are given"
            )
        return self

    @property
    def fine(self) -> FineSigns:
        """Where fine signs lie."""
        return FineSigns(unpacked(self.steps, 1, "steps"))

    def pose(self, frame: AffineFrame, surface: Surface) -> Warp:
        """Return the map that lays a surface in the frame as its moments say."""
        shift = frame.matrix @ (surface.middle - frame.centroid) + self.offset
        return Warp.linear(surface.size * frame.matrix, shift)

    def home_pose(self, surface: Surface) -> Warp:
        """Return the map that lays a surface in the frame as if it never moved."""
        matrix, shift = np.reshape(self.home[:9], (3, 3)), np.array(self.home[9:])
        return Warp.linear(surface.size * matrix, matrix @ surface.middle + shift)


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

    version: ClassVar[int] = 8

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
            + (f", fewer blocks than {laid}," if laid > 1 else "")
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
        """Mend the surface, smooth crumples, pose, lay the surface over the landmarks, read the volume image.

        Of the poses of a symmetric solid the landmarks choose one, and they lie on what the right key made of
        the surface: on an unmarked one, too, that key does better there than in the others. So all of them
        count as tries. See `Scheme.evidence`.
        """
        known = self._known
        mesh = whole_surface(mesh)
        landmarks = Landmarks.decode(known.landmarks)
        try:
            mesh, frames = recognized(
                denoised(mesh, known.area), SolidMoments.of_entries(known.moments), known.ways
            )
        except NoSolidError:  # as what one view of a scanner saw: the landmarks alone may tell where it lies
            surface, tries = Surface.of(mesh), known.ways
            found = registered(surface, landmarks, (known.home_pose(surface),))
            if found.share < CLEAR:
                raise
        else:
            surface, tries = Surface.of(mesh), len(frames)
            pose = nearest(surface, landmarks, [known.pose(frame, surface) for frame in frames])
            found = registered(surface, landmarks, (pose, known.home_pose(surface)))
        layout = Layout(known.grid, known.hmin, known.height)
        image = layout.image(found.warp(surface.placed(mesh.vertices)), mesh)
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
