"""The rules of the static gate, one concept per file; read `rule` first, `gate.static_gate` lists them in order."""
