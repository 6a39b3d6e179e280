"""What a study file may contain, key by key.

Units are part of the keys. A key without its unit, or with a typing error, is an error that says
what was probably meant. One file per part of a study; `study.py` puts them together.
"""

from elastocal.files.schema.campaign import CampaignFile, MotionFile
from elastocal.files.schema.constraints import (
    BoxFile,
    CollisionFile,
    ConstraintsFile,
    CylinderFile,
    ElevationFile,
    ObstacleFile,
    TiltFile,
    WorkspaceFile,
)
from elastocal.files.schema.experiments import (
    ConeFile,
    ExperimentsFile,
    InstrumentFile,
    PriorFile,
    TestPoseFile,
    TrackerFile,
)
from elastocal.files.schema.mapping import ColumnFile, FrameFile, MappingFile
from elastocal.files.schema.robot import (
    CheckPoseFile,
    ControllerFile,
    DHRobotFile,
    DHRowFile,
    RobotFile,
    SpringFile,
    ToolFile,
    UrdfRobotFile,
)
from elastocal.files.schema.study import StudyFile, validate
from elastocal.files.schema.values import Section

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
