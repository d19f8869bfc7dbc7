"""Figures of whole libraries: speed of the catalog, near-duplicates that are found."""
