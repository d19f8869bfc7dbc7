"""Insertion of new objects: supports, free space outside the envelope, candidates, placement (start with `insert`)."""
