"""Finding assets by words: a request is read as wishes, each asset answers each wish with evidence."""
