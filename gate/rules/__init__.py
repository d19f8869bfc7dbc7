"""The rules of the static gate, one concept per file; `gate.static_gate` lists them in order."""
