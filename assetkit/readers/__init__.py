"""One reader per source format; each returns the internal `Model`."""
