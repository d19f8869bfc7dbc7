"""The rules of the static gate, one concept per file; `usdio.gate` lists them in order."""
