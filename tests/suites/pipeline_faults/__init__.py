"""Mistakes injected into valid pipelines: what `mana pipeline check` notices, at which line, and what it misses.

Written apart from the reader: it edits text and imports nothing of `dsl` but the check itself (`run`).
"""
