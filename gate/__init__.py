"""Plausibility rules over released USD packages, and the outside validators that judge the same files."""
