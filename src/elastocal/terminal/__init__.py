"""What the commands show: tables and progress bars, by rich. One file per command family."""
