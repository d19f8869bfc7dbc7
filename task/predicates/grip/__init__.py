"""Grippers and objects: held between fingers, lifted, released."""
