"""Pictures of assets and recordings, rendered on the CPU in a child process. Read `views` first."""
