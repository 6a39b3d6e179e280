"""What a study file may contain, key by key.

Units are part of the keys. A key without its unit, or with a typing error, is an error that says
what was probably meant. One file per part of a study; `study.py` puts them together.
"""

from elastocal.io.schema.constraints import (
    BoxFile,
    ConstraintsFile,
    ElevationFile,
    TiltFile,
    WorkspaceFile,
)
from elastocal.io.schema.experiments import (
    ConeFile,
    ExperimentsFile,
    InstrumentFile,
    PriorFile,
    TestPoseFile,
    TrackerFile,
)
from elastocal.io.schema.robot import DHRobotFile, DHRowFile, SpringFile, ToolFile
from elastocal.io.schema.study import StudyFile, validate
from elastocal.io.schema.values import Section

__all__ = [
    "BoxFile",
    "ConeFile",
    "ConstraintsFile",
    "DHRobotFile",
    "DHRowFile",
    "ElevationFile",
    "ExperimentsFile",
    "InstrumentFile",
    "PriorFile",
    "Section",
    "SpringFile",
    "StudyFile",
    "TestPoseFile",
    "TiltFile",
    "ToolFile",
    "TrackerFile",
    "WorkspaceFile",
    "validate",
]
