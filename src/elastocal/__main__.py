"""The program `elastocal`, also as `python -m elastocal`."""

from __future__ import annotations

import sys


def main() -> None:
    """Run the command line; stopped while it is still loading, it ends as quietly as later."""
    try:
        from elastocal.cli import app
        from elastocal.terminal.plain import spell_what_cannot_be_written

        spell_what_cannot_be_written()
        app(prog_name="elastocal")
    except KeyboardInterrupt:
        sys.stderr.write("stopped; no file was changed\n")
        sys.exit(130)


if __name__ == "__main__":
    main()
