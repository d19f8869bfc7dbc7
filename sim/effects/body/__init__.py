"""Effects on a body's mass properties and size."""
