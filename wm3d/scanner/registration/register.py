"""Laying a surface over landmarks: from the poses it may have, or from every side where they fail."""

from collections.abc import Iterable

import numpy as np

from wm3d.scanner.registration.fit import NEAR, Fit, fitted, share_met
from wm3d.scanner.registration.fit_kernels import FLOOR
from wm3d.scanner.registration.landmarks import Landmarks
from wm3d.scanner.registration.search import Search, turned_starts
from wm3d.scanner.registration.surface import Surface
from wm3d.scanner.registration.warp import Warp
from wm3d.threads import two_threads

EXACT = FLOOR / 2
"""Distance at which half of the landmarks must be met for a pose to be left as it is."""

FEWEST = 60
"""Fewest landmarks that say more than a pose; few have a normal where a model is all edges."""

SURE = 0.85
"""Share of the landmarks met at which a pose is taken, and no other and no turned start tried. What is found
from such a start must meet it `CLOSELY`. A smooth model that lost a part may meet 0.86 in the wrong place, or
mirrored."""

GAIN = 0.03
"""By how much the share of the landmarks met must grow for a fit to be preferred to a simpler one."""

FAR_REACH = 1.0
"""Reach of a fit from a turned start."""

FLATTENING = 1e6
"""Condition of a pose from which it has no inverse to speak of."""

SKETCH, SKETCH_ROUNDS = 3, 15
"""Turned starts are tried on one landmark in so many, for so many rounds."""

FINALISTS = 2
"""How many of the sketches are fitted in full. Of 231 parts of which one was right, most of them a third or a
fifth of a model, it was the best in 228 and the second in 2."""

FURTHER = (
    Search(mirrored=False, whole=True),
    Search(mirrored=True, whole=False),
    Search(mirrored=True, whole=True),
)
"""What is looked for after a part of the model, while less than `SURE` is met."""

DOUBTFUL = 0.65
"""Share met below which the whole model is looked for, amid something that was added."""

PROMISING, UNLIKELY, CLOSELY = 0.75, 0.06, NEAR / 2
"""There a start is left where its sketch meets less than this part of what is met already, and a fit where it
does not meet so much more at that distance: a model may be nearly its own mirror image. From farther on a
smooth one meets nearly as much in wrong places."""


def registered(surface: Surface, landmarks: Landmarks, fits: Iterable[Fit], *, mirrored: bool = False) -> Fit:
    """Return the warp that lays a surface over landmarks, and what share of them it meets.

    Only the shape decides, never a key: the p-value of a detector that reads the warped mesh stays exact.

    Parameters
    ----------
    surface : Surface
    landmarks : Landmarks
    fits : iterable of Fit
        What `posed` makes of the poses that may lay the surface over the landmarks already, the likeliest
        first; asked for no more once one does.
    mirrored : bool, optional
        Whether turned starts are tried with the mirror image, too; see `Warp.mirrors`.
    """

    def closely(fit: Fit) -> float:
        return share_met(surface, landmarks, fit.warp, CLOSELY)

    tried = []
    for fit in fits:
        if len(landmarks.points) < FEWEST or fit.exact or fit.share >= SURE:
            return fit
        tried.append(fit)
    sound = [fit for fit in tried if not _presses_flat(fit.warp)]
    best = _best([*sound, *_searched(surface, landmarks, Search(mirrored=False, whole=False))])
    for search in FURTHER:
        if closely(best) >= SURE:
            break
        if (search.mirrored and not mirrored) or (search.whole and best.share >= DOUBTFUL):
            continue
        others = _searched(surface, landmarks, search, PROMISING * best.share)
        if others and closely(_best(others)) > closely(best) + UNLIKELY:
            best = _best(others)
    return best


def posed(surface: Surface, landmarks: Landmarks, pose: Warp) -> Fit:
    """Return a pose as it is where it lays half of a surface right over landmarks, else the best fit near."""
    if len(landmarks.points) < FEWEST or _presses_flat(pose):
        return Fit(pose, 0.0)
    exact = share_met(surface, landmarks, pose, EXACT) > 0.5
    met = Fit(pose, share_met(surface, landmarks, pose), exact)
    return met if exact else _best([met, *_bent(surface, landmarks, pose)])


def _presses_flat(pose: Warp) -> bool:
    """Tell of a pose without an inverse, which may meet the moments of another model best."""
    return bool(np.linalg.cond(pose.matrix) > FLATTENING)


def _bent(surface: Surface, landmarks: Landmarks, start: Warp) -> list[Fit]:
    """Fit a linear map first and then, from there, a quadratic one."""
    linear = fitted(surface, landmarks, start, quadratic=False)
    return [linear, fitted(surface, landmarks, linear.warp, quadratic=True)]


def _best(fits: list[Fit]) -> Fit:
    """Return the last fit that is better by `GAIN` than the best before it."""
    best = fits[0]
    for fit in fits[1:]:
        best = fit if fit.share > best.share + GAIN else best
    return best


def _searched(surface: Surface, landmarks: Landmarks, search: Search, least: float = 0.0) -> list[Fit]:
    """Return the fits from the turned starts whose sketches meet most landmarks, and so many at `least`."""
    sketch = landmarks.every(SKETCH)

    def sketched(start: Warp) -> Fit:
        return fitted(surface, sketch, start, quadratic=False, reach=FAR_REACH, rounds=SKETCH_ROUNDS)

    def finished(fit: Fit) -> Fit:
        return _best(_bent(surface, landmarks, fit.warp))

    with two_threads() as threads:
        fits = threads.map(sketched, turned_starts(surface, landmarks, search))
        best = sorted(fits, key=lambda fit: -fit.share)[:FINALISTS]
        return list(threads.map(finished, [fit for fit in best if fit.share >= least]))
