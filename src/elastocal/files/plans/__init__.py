"""Plan files and run sheets."""
