"""Packages and their sources drawn by a renderer that is not ours, and by ours, and compared as people see."""
