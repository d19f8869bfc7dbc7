"""From files to arrays: YAML with positions, tables, columns by our names."""
