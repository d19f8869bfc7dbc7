"""Reads .blend files through Blender."""
