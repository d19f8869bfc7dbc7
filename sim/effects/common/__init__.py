"""Helpers shared by effects: columns of whole recordings, values of one joint or link of a mechanism."""
