"""Emission of a compiled scene: the saved scene document and what USD writers need."""
