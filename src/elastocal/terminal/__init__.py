"""Tables and progress on the screen, one file per command family."""
