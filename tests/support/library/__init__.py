"""Libraries made in a moment: packages with sample records, and records alone."""
