"""Blender in an environment of its own: installing it, and converting .blend files in a child process."""
