"""Explanations of a verdict: results by combination, minimal conflicts, suggested edits and the report's finding."""
