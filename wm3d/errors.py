"""The one exception that wm3d raises for bad input; its text is one sentence a user can act on."""

import reprlib
from typing import Any

_short = reprlib.Repr()
_short.maxstring = _short.maxother = 80


def shown(value: Any) -> str:
    """Return the repr of a value for a message, without the middle of one that would fill the screen."""
    try:
        return _short.repr(value)
    except ValueError:  # Python writes no integer of thousands of digits
        return f"a {type(value).__name__} of too many digits"


class Wm3dError(ValueError):
    """Bad input: a file, a mesh, a key, a config or a parameter that wm3d cannot work with.

    The message is one sentence that names the file or the parameter, the offending value and, where there
    is one, the remedy. The command line prints it on stderr and exits with status 2.
    """
