"""Causes that a mechanism case can hide: library effects, outside causes, and which are hidden together."""
