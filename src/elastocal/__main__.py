"""`python -m elastocal`."""

from elastocal.cli import app

app(prog_name="elastocal")
