"""The report of a search: localised error, side-by-side roll-outs, the HTML page."""
