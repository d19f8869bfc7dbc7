"""Binding of a scene program to asset packages: assets, anchors, variants and relations become placement problems.

Start with `components.lower`.
"""
