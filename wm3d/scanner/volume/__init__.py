"""The scanner that sees through a model: the volume of the solid behind each cell of its cylinder."""

from wm3d.scanner.volume.image import VolumeImage, volume_image, volume_image_reference, volume_jacobian

__all__ = ["VolumeImage", "volume_image", "volume_image_reference", "volume_jacobian"]
