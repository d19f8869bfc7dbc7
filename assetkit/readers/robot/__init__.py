"""Reads robot descriptions (URDF, MJCF) into a source model: meshes and primitives of all links at rest, mechanism."""
