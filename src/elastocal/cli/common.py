"""What every command shares: the application, error handling, options, safe output paths."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastocal import __version__
from elastocal.errors import ElastocalError, InputError

if TYPE_CHECKING:
    from elastocal.study.study import Study

app = typer.Typer(
    help="Elastostatic calibration of robot arms: plan, identify, validate, compensate.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)

StudyPath = Annotated[Path, typer.Argument(help="Study file (YAML).", show_default=False)]
Seed = Annotated[int, typer.Option(help="Same seed, same result.", min=0)]
Json = Annotated[bool, typer.Option("--json", help="Print JSON for programs.")]


def guarded(command: Callable[..., None]) -> Callable[..., None]:
    """Turn our errors into one sentence and an exit code."""

    @wraps(command)
    def run(*args: Any, **kwargs: Any) -> None:
        try:
            command(*args, **kwargs)
        except ElastocalError as error:
            print(f"error: {error}", file=sys.stderr)
            raise typer.Exit(error.exit_code) from None
        except KeyboardInterrupt:
            print("stopped; no file was changed", file=sys.stderr)
            raise typer.Exit(130) from None
        except BrokenPipeError:
            sys.stderr.close()
            raise typer.Exit(0) from None
        except OSError as error:
            print(f"error: {error.strerror or error}", file=sys.stderr)
            raise typer.Exit(2) from None

    return run


def _version(wanted: bool) -> None:
    if wanted:
        print(f"elastocal {__version__}")
        raise typer.Exit


@app.callback()
def main(
    version: Annotated[
        bool, typer.Option("--version", help="Show the version.", callback=_version, is_eager=True)
    ] = False,
) -> None:
    """Elastostatic calibration of robot arms: plan, identify, validate, compensate."""


def study_at(path: Path) -> Study:
    """The study in a file."""
    from elastocal.files.study.study_file import read_study

    return read_study(path)


def study_of_plan(plan: Path, study: Path | None) -> Study:
    """The study of a plan: the one in a file, or else the one embedded in the plan."""
    from elastocal.files.study.embedded_study import embedded_study

    return embedded_study(plan) if study is None else study_at(study)


def demo_file(name: str) -> Path:
    """Where a file of the example that comes with the package is."""
    return Path(__file__).parents[1] / "demo" / name


def overridden(
    study: Study, count: int | None, configurations: int | None, criterion: str | None
) -> Study:
    """The study with what the command line says instead."""
    experiments = study.experiments
    if count is not None:
        experiments = replace(experiments, count=count)
    if configurations is not None:
        experiments = replace(experiments, max_configurations=configurations)
    if criterion is not None:
        study = replace(study, criterion=criterion)
    return replace(study, experiments=experiments)


def progress(title: str) -> Any:
    """A progress bar, as a context that yields a function to tell it."""
    from elastocal.terminal.console import progress as bar

    return bar(title)


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
    if any(path.resolve() == given.resolve() for given in inputs):
        raise InputError(f"{path}: would be written over the file it is made from")


def print_json(document: Any) -> None:
    """Print a document for programs."""
    import json

    from elastocal.files.texts import finite

    narrow = not (sys.stdout.encoding or "").lower().startswith("utf")
    print(json.dumps(finite(document), indent=2, ensure_ascii=narrow, allow_nan=False))
