"""The controlled vocabulary: what kinds of things there are, as tables, and one typed loader (`tables`)."""
