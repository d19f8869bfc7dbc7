"""Effects on contact: friction, restitution, compliance, rolling and spinning friction, anisotropy."""
