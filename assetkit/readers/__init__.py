"""One reader per source format; each returns the internal `Model`. `by_format` lists them."""
