"""The exception that wm3d raises for bad input; its text is one sentence a user can act on."""

import difflib
import reprlib
import traceback
from collections.abc import Iterable
from pathlib import Path
from typing import Any

LONGEST = 80
"""Characters of a value that a message shows at most."""

SHORTEST, MOST_MEANT, ALIKE = 3, 3, 0.6
"""Letters of a word for which names that contain it are looked up, how many of these are told, and how alike
another name must be (`difflib`)."""

_short = reprlib.Repr()
_short.maxstring = _short.maxother = LONGEST


def shown(value: Any) -> str:
    """Return the repr of a value for a message, without the middle of one that would fill the screen."""
    try:
        return _short.repr(value)
    except ValueError:  # Python writes no integer of thousands of digits
        return f"a {type(value).__name__} of too many digits"


def shortened(text: str) -> str:
    """Return a text for a message, without the middle of one that would fill the screen."""
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 20]}...{text[-17:]}"


def hint(word: str, known: Iterable[str], otherwise: str = "") -> str:
    """Return which of the known names was meant: those that contain the word, else the most alike.

    Where none is, `otherwise`, or all of them.
    """
    names = list(known)
    near = [name for name in names if len(word) >= SHORTEST and word in name]
    near = near or difflib.get_close_matches(word, names, n=1, cutoff=ALIKE)
    if len(near) not in range(1, MOST_MEANT + 1):
        return otherwise or f"known: {', '.join(names) or 'none'}."
    return f"did you mean {' or '.join(map(repr, near))}?"


class Wm3dError(ValueError):
    """Bad input: a file, a mesh, a key, a config or a parameter that wm3d cannot work with.

    The message is one sentence that names the file or the parameter, the offending value and, where there
    is one, the remedy. The command line prints it on stderr and exits with status 2.
    """


def in_words(error: Exception) -> str:
    """Return what an error says; of one that wm3d did not foresee also its kind and where it was raised."""
    if isinstance(error, Wm3dError):
        return str(error)
    frames = traceback.extract_tb(error.__traceback__)
    where = f" ({Path(frames[-1].filename).name}, line {frames[-1].lineno})" if frames else ""
    return f"{type(error).__name__}: {error}{where}"


class NoSolidError(Wm3dError):
    """The faces of a mesh bound no solid, so it has no moments that could pose it."""
