"""Cells (child processes with limits), the content-addressed cache and scheduling. Knows nothing of assets."""
