"""Deterministic damage to files by kind; `by_suffix.mutate` picks among bytes, tokens of text, and trees."""
