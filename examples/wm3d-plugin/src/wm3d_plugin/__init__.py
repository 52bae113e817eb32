"""A plug-in for wm3d: the scheme `latitude-bands` and the attack `dents`, named in pyproject.toml."""
