"""Category of an object: evidence in, ranked hypotheses out. Start with `annotator`."""
