"""Metric scale of one object: declared units, clues in the file, sizes of its category. Start with `declared_units`."""
