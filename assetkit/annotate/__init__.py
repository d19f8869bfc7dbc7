"""What kind of thing an object is: evidence in, ranked hypotheses of its category out."""
