"""The one exception that wm3d raises for bad input; its text is one sentence a user can act on."""


class Wm3dError(ValueError):
    """Bad input: a file, a mesh, a key, a config or a parameter that wm3d cannot work with.

    The message is one sentence that names the file or the parameter, the offending value and, where there
    is one, the remedy. The command line prints it on stderr and exits with status 2.
    """
