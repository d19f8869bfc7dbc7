"""Explanations of a verdict: minimal conflicts, suggested edits, relaxed problems and the report."""
