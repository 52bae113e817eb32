"""The tree of boxes in which nearest points are searched."""
