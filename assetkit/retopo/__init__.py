"""Retopology: a light mesh with a new texture atlas, onto which the maps of a heavy source surface are baked."""
