"""Reads foreign USD into `schemas.model.Model`, guarded against hostile layers. Start with `asset`."""
