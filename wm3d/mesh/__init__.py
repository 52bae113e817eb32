"""Meshes: the immutable triangle mesh, its files, its moments and the registry of named data."""
