"""Reader of PLY files, text and binary, into a source model."""
