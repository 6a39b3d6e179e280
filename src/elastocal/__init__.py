"""elastocal: elastostatic calibration of robot arms, from the plan to the corrected path.

The public names, in the order of the work: get a robot and a study, look at it, plan, prove, judge,
compare, measure, identify, validate, compensate, simulate, export, show. Modules are loaded when a
name is first used, so that importing is instant.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

_PUBLIC = {
    "Joint": "elastocal.robot.chain",
    "Robot": "elastocal.robot.chain",
    "Tool": "elastocal.robot.chain",
    "load_robot": "elastocal.robot.sources",
    "from_dh": "elastocal.robot.sources",
    "from_urdf": "elastocal.robot.sources.urdf",
    "Coupling": "elastocal.robot.controller_axes",
    "DHRow": "elastocal.robot.sources",
    "LoadCases": "elastocal.elastic.load_cases",
    "forward_kinematics": "elastocal.robot.posture",
    "jacobian": "elastocal.robot.posture",
    "joint_springs": "elastocal.elastic.springs",
    "regressor": "elastocal.elastic.regressor",
    "deflection": "elastocal.elastic.regressor",
    "cartesian_stiffness": "elastocal.elastic.regressor",
    "cartesian_compliance": "elastocal.elastic.cartesian",
    "Known": "elastocal.study.known",
    "with_known": "elastocal.study.two_steps",
    "Nuisance": "elastocal.elastic.nuisance",
    "CaseErrors": "elastocal.elastic.case_errors",
    "with_nuisance": "elastocal.study.two_steps",
    "FixedVector": "elastocal.elastic.allowed_loads",
    "FreeDirection": "elastocal.elastic.allowed_loads",
    "InPlane": "elastocal.elastic.allowed_loads",
    "HalfSpace": "elastocal.constraints",
    "MinRadius": "elastocal.constraints",
    "Elevation": "elastocal.constraints",
    "Tilt": "elastocal.constraints",
    "default_clearances": "elastocal.constraints.cell",
    "TestPose": "elastocal.study.study",
    "test_pose": "elastocal.study.study",
    "TestPath": "elastocal.study.test_path",
    "test_path": "elastocal.study.test_path",
    "Isotropic": "elastocal.measuring.instrument",
    "LaserTracker": "elastocal.measuring.instrument",
    "PoseProbe": "elastocal.measuring.instrument",
    "Experiments": "elastocal.study.study",
    "Study": "elastocal.study.study",
    "read_study": "elastocal.files.study.study_file",
    "check": "elastocal.planning.study_check",
    "plan": "elastocal.planning.plan",
    "several_cores": "elastocal.cores",
    "Plan": "elastocal.planning.plan",
    "Effort": "elastocal.design.exact",
    "Certificate": "elastocal.planning.certificate",
    "lower_bound": "elastocal.planning.certificate",
    "prove": "elastocal.proof.prove",
    "Proof": "elastocal.proof.prove",
    "Done": "elastocal.study.before",
    "done": "elastocal.planning.remaining",
    "remaining": "elastocal.planning.remaining",
    "write_plan": "elastocal.files.plans.plan_file",
    "write_run_sheet": "elastocal.files.plans.plan_file",
    "read_plan": "elastocal.files.plans.plan_file",
    "read_proposal": "elastocal.files.plans.proposal_file",
    "assess": "elastocal.planning.assessment",
    "evaluate": "elastocal.planning.evaluation",
    "random_plans": "elastocal.planning.trade_off",
    "in_test_poses": "elastocal.planning.baseline",
    "trade_off": "elastocal.planning.trade_off",
    "time_trade_off": "elastocal.planning.trade_off",
    "ElasticArm": "elastocal.elastic.arm",
    "equilibrium": "elastocal.elastic.equilibrium",
    "loaded_deflection": "elastocal.elastic.deflections",
    "Measurements": "elastocal.measuring.measurements",
    "read_measurements": "elastocal.files.measurements.measurement_file",
    "write_measurements": "elastocal.files.measurements.measurement_file",
    "ComplianceModel": "elastocal.elastic.compliance_model",
    "merged_models": "elastocal.elastic.compliance_model",
    "Fit": "elastocal.identification.fit",
    "identify": "elastocal.identification.identify",
    "Identification": "elastocal.identification.result",
    "validate": "elastocal.identification.validation",
    "leave_one_out": "elastocal.identification.validation",
    "compensate": "elastocal.compensation.compensate",
    "compensate_linearly": "elastocal.compensation.compensate",
    "residual": "elastocal.compensation.compensate",
    "compensate_calibrated": "elastocal.compensation.calibrated",
    "Compensation": "elastocal.compensation.compensate",
    "read_path": "elastocal.files.paths.path_file",
    "write_corrected": "elastocal.files.paths.corrected_file",
    "true_robot": "elastocal.simulation.true_robot",
    "TrueRobot": "elastocal.simulation.true_robot",
    "simulate": "elastocal.simulation.virtual_campaign",
    "LoadError": "elastocal.simulation.virtual_campaign",
    "Outliers": "elastocal.simulation.virtual_campaign",
    "Reality": "elastocal.simulation.virtual_campaign",
    "campaigns": "elastocal.simulation.monte_carlo",
    "error_left": "elastocal.simulation.with_nuisance",
    "MonteCarlo": "elastocal.simulation.campaigns",
    "read_model": "elastocal.files.models.model_file",
    "write_model": "elastocal.files.models.writing",
    "CalibratedRobot": "elastocal.calibration.calibrated_robot",
    "read_calibration": "elastocal.files.models.calibration_file",
    "write_calibration": "elastocal.files.models.calibration_writing",
    "Approach": "elastocal.programs.approach",
    "campaign_program": "elastocal.programs.campaign_program",
    "path_program": "elastocal.programs.robot_program",
    "export": "elastocal.programs.writers",
    "Contents": "elastocal.report.contents",
    "html": "elastocal.report",
}

__all__ = list(_PUBLIC)


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"module 'elastocal' has no attribute {name!r}")
    return getattr(import_module(_PUBLIC[name]), "load" if name == "load_robot" else name)


def __dir__() -> list[str]:
    return [*_PUBLIC, "__version__"]
