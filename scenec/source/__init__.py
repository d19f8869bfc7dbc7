"""From the text of a scene program to its model: parse, resolve includes and overlays, check names and numbers.

Start with `read`; every value keeps its file, line and column.
"""
