"""Batches of sources. Read `run_batch` first: cells, stored results, package ownership, decisions of people, report."""
