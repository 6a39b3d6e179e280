"""Charts: one picture per file, as SVG drawn from values."""
