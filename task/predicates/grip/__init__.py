"""What grippers do to objects."""
