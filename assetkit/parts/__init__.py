"""Parts of an object: proposed, merged, labelled and ordered by size. Start with `find`."""
