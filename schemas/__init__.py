"""Data that crosses a package border or the disk: models, evidence, diagnostics. Standard library, pydantic, numpy."""
