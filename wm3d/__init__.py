"""wm3d: the open benchmark for watermarks in 3D meshes."""
