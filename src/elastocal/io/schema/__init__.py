"""What a study file may contain, key by key.

Units are part of the keys. A key without its unit, or with a typing error, is an error that says
what was probably meant. One file per part of a study; `study.py` puts them together.
"""

from elastocal.io.schema.campaign import CampaignFile, MotionFile
from elastocal.io.schema.constraints import (
    BoxFile,
    CollisionFile,
    ConstraintsFile,
    CylinderFile,
    ElevationFile,
    ObstacleFile,
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
from elastocal.io.schema.mapping import ColumnFile, FrameFile, MappingFile
from elastocal.io.schema.robot import (
    CheckPoseFile,
    ControllerFile,
    DHRobotFile,
    DHRowFile,
    RobotFile,
    SpringFile,
    ToolFile,
    UrdfRobotFile,
)
from elastocal.io.schema.study import StudyFile, validate
from elastocal.io.schema.values import Section

__all__ = [
    "BoxFile",
    "CampaignFile",
    "CheckPoseFile",
    "CollisionFile",
    "ColumnFile",
    "ConeFile",
    "ConstraintsFile",
    "ControllerFile",
    "CylinderFile",
    "DHRobotFile",
    "DHRowFile",
    "ElevationFile",
    "ExperimentsFile",
    "FrameFile",
    "InstrumentFile",
    "MappingFile",
    "MotionFile",
    "ObstacleFile",
    "PriorFile",
    "RobotFile",
    "Section",
    "SpringFile",
    "StudyFile",
    "TestPoseFile",
    "TiltFile",
    "ToolFile",
    "TrackerFile",
    "UrdfRobotFile",
    "WorkspaceFile",
    "validate",
]
