"""Change of the enclosed volume."""

from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, signed_volume
from wm3d.mesh.moments import is_nothing


def volume_change(original: Mesh, other: Mesh) -> float:
    """Relative change of the enclosed volume, 100 (V' / V − 1) in percent; V as `wm3d.mesh.signed_volume`.

    Positive where the other mesh encloses more, whichever way both are wound; −200 for the same mesh turned
    inside out.

    Raises
    ------
    Wm3dError
        If the original encloses no volume.
    """
    volume = signed_volume(original)
    if is_nothing(original, volume):
        raise Wm3dError(f"{original.name}: its faces enclose no volume, so a change has no measure.")
    return 100 * (signed_volume(other) / volume - 1)
