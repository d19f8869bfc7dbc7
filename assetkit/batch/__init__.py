"""Batches of sources: one cell per source, stored results, ownership of packages, decisions of people, the report."""
