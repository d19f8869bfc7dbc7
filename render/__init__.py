"""Pictures of assets, made on the CPU in a child process."""
