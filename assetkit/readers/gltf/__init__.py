"""Reader of glTF 2.0 and GLB files, split by the sections of the specification, into a source model."""
