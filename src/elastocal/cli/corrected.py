"""Corrected paths, for the commands that write them: as robot programs, and when not at all.

Imported by the commands when they run.
"""

from __future__ import annotations

from pathlib import Path

from elastocal.cli.programs import said, write_program
from elastocal.compensation.compensate import Compensation
from elastocal.errors import InfeasibleError
from elastocal.files.paths.path_file import ToolPath
from elastocal.files.texts import file_hash
from elastocal.programs.robot_program import Provenance, path_program
from elastocal.programs.writers import Settings
from elastocal.study.absolute import AbsoluteStudy
from elastocal.study.study import Study
from elastocal.wording import together


def path_program_of(
    study: Study | AbsoluteStudy,
    done: Compensation,
    task: ToolPath,
    to: str,
    settings: Settings,
    out: Path,
    given: list[Path],
    models: list[Path],
    force: bool,
) -> list[str]:
    """Write the corrected path as a robot program, named after the corrected file; what to tell."""
    program = path_program(
        study.robot,
        done.q,
        name=out.stem,
        purpose=f"Path {Path(task.source).name} corrected for its loads, {done.rule} rule.",
        provenance=Provenance(
            study.name,
            task.sha256,
            of="path",
            beside=tuple(
                (what, file_hash(file))
                for what, files in (("model", models), ("study", given[:1]))
                for file in files
            ),
        ),
    )
    files = write_program(program, to, settings, out.parent, *given, out, force=force)
    return said(files, to, settings)


def refuse_undrivable(done: Compensation, task: ToolPath) -> None:
    """Write nothing that cannot be driven: name the first point and how many there are."""
    for wrong, what in (
        (~done.converged, "cannot be corrected"),
        (done.beyond_limits.any(axis=1), "would leave the joint limits"),
    ):
        if wrong.any():
            i = int(wrong.argmax())
            raise InfeasibleError(
                f"{task.source}: {int(wrong.sum())} of {len(done)} points {what}, the first is "
                f"point {task.names[i]} in line {task.lines[i]}: {together(done.doubts[i])}"
            )
