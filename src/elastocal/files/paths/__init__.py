"""Paths to be corrected, and corrected paths."""
