"""Insertion of new objects: free space outside the envelope, supports, candidates, placement."""
