"""Reads written packages (`body`) and scenes (`scene`) back from disk, as a simulator would."""
