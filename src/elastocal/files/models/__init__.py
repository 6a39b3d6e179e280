"""Model files, and files of campaigns."""
