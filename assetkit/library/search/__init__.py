"""Search in a library: a request is parsed into criteria (`query`), and each asset is matched with each (`match`)."""
