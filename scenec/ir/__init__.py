"""Intermediate representation of a scene: the placement problem, its names and the cache of derived values."""
