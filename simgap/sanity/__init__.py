"""Checks that precede a search: wrong conventions of the file, inputs that belong to other trials."""
