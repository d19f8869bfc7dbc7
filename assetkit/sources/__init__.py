"""Source files of a batch: discovery, dependencies, and the split of a file into objects."""
