"""Formats of recordings: `read` finds the reader of a path (one file for each format), `write` copies a recording."""
