"""The program `elastocal`, also as `python -m elastocal`."""

from __future__ import annotations

import sys


def main() -> None:
    """Run the command line; stopped while it is still loading, it ends as quietly as later."""
    try:
        import signal

        from typer.main import get_command

        from elastocal.cli import application
        from elastocal.terminal.plain import spell_what_cannot_be_written

        spell_what_cannot_be_written()
        command = get_command(application("".join(sys.argv[1:2])))
    except KeyboardInterrupt:
        sys.stderr.write("stopped; no file was changed\n")
        sys.exit(130)
    try:
        command.main(prog_name="elastocal")
    except SystemExit as end:
        if end.code != 130:  # all is said and done: Ctrl-C has nothing to stop any more
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        raise
    except KeyboardInterrupt:  # while it was being said how it ended
        sys.exit(130)


if __name__ == "__main__":
    main()
