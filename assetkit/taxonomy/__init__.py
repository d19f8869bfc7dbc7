"""The vocabulary of categories, materials, masses and sizes as CSV tables, with typed loaders. Start with `tables`."""
