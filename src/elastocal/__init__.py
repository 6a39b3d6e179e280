"""elastocal: elastostatic calibration of robot arms, from the plan to the corrected path.

The public names, in the order of the work: get a robot and a study, look at it, plan, judge,
compare, measure, identify, validate, compensate, simulate, export, show. Modules are loaded when
a name is first used, so that importing is instant.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

_PUBLIC = {
    "Joint": "elastocal.robot",
    "Robot": "elastocal.robot",
    "Tool": "elastocal.robot",
    "load_robot": "elastocal.robots",
    "from_dh": "elastocal.robots",
    "from_urdf": "elastocal.robots",
    "Coupling": "elastocal.coupling",
    "DHRow": "elastocal.robots",
    "LoadCases": "elastocal.load_case",
    "forward_kinematics": "elastocal.posture",
    "jacobian": "elastocal.posture",
    "joint_springs": "elastocal.elastostatics",
    "regressor": "elastocal.elastostatics",
    "deflection": "elastocal.elastostatics",
    "cartesian_stiffness": "elastocal.elastostatics",
    "FixedVector": "elastocal.loads",
    "FreeDirection": "elastocal.loads",
    "HalfSpace": "elastocal.constraints",
    "MinRadius": "elastocal.constraints",
    "Elevation": "elastocal.constraints",
    "Tilt": "elastocal.constraints",
    "TestPose": "elastocal.study",
    "test_pose": "elastocal.study",
    "Isotropic": "elastocal.instrument",
    "LaserTracker": "elastocal.instrument",
    "Experiments": "elastocal.study",
    "Study": "elastocal.study",
    "read_study": "elastocal.io.study_file",
    "check": "elastocal.checkup",
    "plan": "elastocal.planning",
    "Plan": "elastocal.planning",
    "Effort": "elastocal.design.exact",
    "Certificate": "elastocal.certification",
    "lower_bound": "elastocal.certification",
    "Done": "elastocal.study",
    "done": "elastocal.replanning",
    "remaining": "elastocal.replanning",
    "write_plan": "elastocal.io.plan_file",
    "write_run_sheet": "elastocal.io.plan_file",
    "read_proposal": "elastocal.io.proposal_file",
    "assess": "elastocal.assessment",
    "evaluate": "elastocal.evaluation",
    "random_plans": "elastocal.comparison",
    "trade_off": "elastocal.comparison",
    "time_trade_off": "elastocal.time_curves",
    "ElasticArm": "elastocal.elastic_arm",
    "equilibrium": "elastocal.equilibrium",
    "loaded_deflection": "elastocal.equilibrium",
    "Measurements": "elastocal.measurement",
    "read_measurements": "elastocal.io.measurement_file",
    "write_measurements": "elastocal.io.measurement_file",
    "ComplianceModel": "elastocal.compliance_model",
    "merged_models": "elastocal.compliance_model",
    "Fit": "elastocal.uncertainty",
    "identify": "elastocal.identification",
    "Identification": "elastocal.identification",
    "validate": "elastocal.validation",
    "leave_one_out": "elastocal.validation",
    "compensate": "elastocal.compensation",
    "compensate_linearly": "elastocal.compensation",
    "residual": "elastocal.compensation",
    "Compensation": "elastocal.compensation",
    "read_path": "elastocal.io.path_file",
    "write_corrected": "elastocal.io.corrected_file",
    "simulate": "elastocal.simulation",
    "LoadError": "elastocal.simulation",
    "Outliers": "elastocal.simulation",
    "campaigns": "elastocal.monte_carlo",
    "MonteCarlo": "elastocal.monte_carlo",
    "read_model": "elastocal.io.model_file",
    "write_model": "elastocal.io.model_file",
    "campaign_program": "elastocal.campaign_program",
    "path_program": "elastocal.robot_program",
    "export": "elastocal.io.exports",
    "html": "elastocal.report",
}

__all__ = list(_PUBLIC)


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"module 'elastocal' has no attribute {name!r}")
    return getattr(import_module(_PUBLIC[name]), "load" if name == "load_robot" else name)


def __dir__() -> list[str]:
    return [*_PUBLIC, "__version__"]
