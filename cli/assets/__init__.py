"""`mana assets`: ingest, list, search, show, review, validate and render packages."""
