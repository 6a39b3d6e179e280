"""What every command shares: the application, options, safe output paths."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from elastocal import __version__
from elastocal.cli.ending import Commands
from elastocal.cli.number_options import Application
from elastocal.errors import InputError

app = Application(
    cls=Commands,
    help="Elastostatic calibration of robot arms: plan, identify, validate, compensate.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)

StudyPath = Annotated[
    Path, typer.Argument(metavar="study", help="Study file (YAML).", show_default=False)
]
Seed = Annotated[int, typer.Option(help="Same seed, same result.", min=0)]
Json = Annotated[bool, typer.Option("--json", help="Print JSON for programs.")]
Readings = Annotated[
    list[Path],
    typer.Argument(metavar="MEASUREMENTS", help="Measured deflections (CSV).", show_default=False),
]
Mapping = Annotated[
    Path | None, typer.Option(help="What foreign columns mean (YAML).", show_default=False)
]
Planned = Annotated[
    Path | None,
    typer.Option(
        "--plan", help="Plan whose joints and loads the experiments have.", show_default=False
    ),
]
Prior = Annotated[Path | None, typer.Option(help="Model from before, weighed by its covariance.")]
Force = Annotated[
    tuple[float, float, float] | None,
    typer.Option(help="Force of every point, base frame.", show_default=False),
]
Torque = Annotated[
    tuple[float, float, float] | None,
    typer.Option(help="Torque of every point, base frame.", show_default=False),
]
Start = Annotated[
    str | None,
    typer.Option(help='Near the first point, for paths of poses: "A1=0deg A2=-90deg …".'),
]
Overwrite = Annotated[
    bool, typer.Option("--force", help="Write over files that elastocal did not write.")
]
Workers = Annotated[
    int | None,
    typer.Option(
        help="Processes where solids are measured pair by pair; all cores if not given.", min=1
    ),
]
ScriptNode = Annotated[
    bool, typer.Option("--for-script-node", help="URScript that calls its function itself.")
]
CONTROLLERS = "krl, rapid, fanuc, urscript, ros or csv"
"""What `--to` takes, for help that loads no writer; a test compares it with the writers."""
ROBOT_FILES = "urdf, dh, mdh, json or table"
"""The same for calibrated robots."""
Known = Annotated[
    Path | None, typer.Option(help="Model of further joints, which bend; instead of the study's.")
]


def _version(wanted: bool) -> None:
    if wanted:
        from elastocal.core.library import described

        print(f"elastocal {__version__}, {described()}")
        raise typer.Exit


@app.callback()
def main(
    version: Annotated[
        bool, typer.Option("--version", help="Show the version.", callback=_version, is_eager=True)
    ] = False,
) -> None:
    """Elastostatic calibration of robot arms: plan, identify, validate, compensate."""


def demo_file(name: str) -> Path:
    """Where a file of the example that comes with the package is."""
    return Path(__file__).parents[1] / "demo" / name


def writable(path: Path, *inputs: Path, suffix: str = "") -> None:
    """Refuse at once what would fail after the work is done, or destroy what it starts from."""
    import os

    if not path.parent.is_dir():
        raise InputError(f"{path}: the folder {path.parent} does not exist")
    if path.is_dir():
        raise InputError(f"{path}: is a folder, expected a file name")
    if path.exists() and not path.is_file():
        raise InputError(f"{path}: is not an ordinary file")
    if not os.access(path.parent, os.W_OK):
        raise InputError(f"{path}: the folder {path.parent} cannot be written to")
    if suffix and path.suffix.lower() != suffix:
        raise InputError(f"{path}: expected a name that ends in {suffix}")
    if any(_same_file(path, given) for given in inputs):
        raise InputError(f"{path}: would be written over the file it is made from")


def _same_file(one: Path, other: Path) -> bool:
    """Whether two names are of one file, be it by a link or by letters of another case."""
    import os

    if one.exists() and other.exists():
        return one.samefile(other)
    return os.path.realpath(one) == os.path.realpath(other)  # it takes links that lead in a circle


def replaceable(path: Path, kind: str, *, force: bool, text: str = "") -> None:
    """Refuse to write over a file that is not ours.

    Args:
        path: The file to write.
        kind: What is to be written, as its signature says; only the like of it is replaced.
        force: Whether to write over any file.
        text: What is to be written, where that is known: nothing is lost if it is there already.
    """
    from elastocal.writing import SAME, kind_of_file

    if not force and path.exists() and kind_of_file(path, text) not in (kind, SAME):
        raise InputError(
            f"{path}: exists already, and elastocal did not write it as {kind}, or "
            "it was changed since; choose another name, or write over it with --force"
        )


def note_parted(paths: list[Path]) -> None:
    """Say on standard error if beside a plan stands the run sheet of another, or the other way."""
    from elastocal.files.plans.pair import parted

    for path in paths:
        if (other := parted(path)) is not None:
            print(
                f"note: {other.name} beside {path.name} belongs to another plan; make them anew "
                "with 'elastocal plan' before you measure",
                file=sys.stderr,
            )


def print_json(document: Any) -> None:
    """Print a document for programs."""
    import json

    from elastocal.files.texts import finite

    narrow = not (sys.stdout.encoding or "").lower().startswith("utf")
    print(json.dumps(finite(document), indent=2, ensure_ascii=narrow, allow_nan=False))
