"""Source files of a batch: discovery, dependencies, screening, and the split of a file into objects."""
