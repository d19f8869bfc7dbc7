"""Binding of a scene program to packages: assets, anchors, variants and relations become a placement problem."""
