"""Acceptance of one released body: settling trials, checks against the record, stable poses, targeted repair."""
