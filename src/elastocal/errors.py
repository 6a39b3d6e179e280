"""What can go wrong, as types; and what is odd or weak, as values.

    ElastocalError
    ├── InputError          a value or file is wrong                      exit code 2
    │   ├── StudyError      ... in a study file; knows file and line
    │   ├── PlanFileError   ... in a plan file
    │   ├── MeasurementFileError   ... in a measurement file; knows file, line and column
    │   ├── ModelFileError  ... in a model file
    │   ├── PathFileError   ... in a path file; knows file, line and column
    │   └── EquilibriumError   a load case under which the arm gives way
    ├── InfeasibleError     no load case satisfies the constraints        exit code 3
    └── IdentifiabilityError   some compliances cannot be told apart      exit code 4

Every message is one sentence: what is wrong, where, what was found, what is expected.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, Self

Code = Literal[
    # of an identification
    "all-negative",
    "all-held-at-zero",
    "negative",
    "held-at-zero",
    "softer-than-any",
    "noisier-than-promised",
    "quieter-than-promised",
    "few-degrees-of-freedom",
    "noise-beside-errors",
    "unlike-noise",
    "model-error",
    "explains-little",
    "grows-with-load",
    "zero-in-interval",
    "hardly-known-compliance",
    "by-chance",
    "carried",
    "correlated",
    "more-than-stated",
    "shared-with-nuisance",
    "counts-less",
    "outlying",
    "linear-model",
    "parallel",
    "nearly-parallel",
    "other-convention",
    "model-lacks",
    "model-may-lack",
    # of a corrected configuration, and of a compensation
    "gives-way",
    "not-at-rest",
    "rests-elsewhere",
    "beyond-limit",
    "hardly-moves",
    "hardly-turns",
    "rigid-but-loaded",
    "wrong-side",
    "position-only",
    "nothing-to-compensate",
    "no-better",
    "taken-as-zero",
    "tcp-not-read",
    "tool-elsewhere",
    # of a corrected path
    "points-lost",
    "points-beyond-limits",
    "points-nearly-singular",
    "more-than-expected",
    # of a validation, and of virtual campaigns
    "worse-with-model",
    "errors-unexplained",
    "same-load-cases",
    "unlike-predicted",
    "not-covered",
    # of a calibration from absolute readings
    "tracker-drifted",
    "tracker-knocked",
    "hardly-checked",
    "spring-below-zero",
    "not-told",
    "large-errors",
    "model-scatters",
    "smaller-will-do",
    "payload-exact",
    "calibration-lacks",
    # of what experiments can tell apart
    "not-seen",
    "confounded",
    "too-few-experiments",
    "too-few-configurations",
    "too-few-readings",
    "no-configuration",
    "no-freedom",
    # of readings
    "degrees-for-radians",
    "radians-for-degrees",
    "beyond-joint-limits",
    "no-load",
    "other-force",
    "other-direction",
    "no-torques",
    "stuck-sensor",
    "torques-compared",
    "large-deflection",
    "only-noise",
    "against-force",
    "zero-deflection",
    "fewer-readings",
    "marker-not-measured",
    "unfinished",
    "impossible-joints",
    "impossible-loads",
    "impossible-deflections",
    "impossible-zeros",
    "impossible-copies",
    "impossible-signs",
    "impossible-fit",
    "looks-used",
    "rotations-not-used",
    "columns-not-used",
    "rotation-unit",
    "rotation-sign",
    "unlike-arm",
    "readings-turned",
    "probe-turned",
    # of a study
    "small-tool",
    "large-tool",
    "small-angles",
    "small-pose-force",
    "pose-below-floor",
    "robot-below-floor",
    "small-force",
    "coarse-sigma",
    "near-tracker",
    "short-range",
    "small-obstacle",
    "thin-links",
    "no-task",
    "taken-as-rigid",
    "rigid-at-test-pose",
    "hardly-known",
    "criterion-renamed",
    "not-watched",
    "hardly-watched",
    "shapes-as-capsules",
    "chain-as-capsules",
    "name-twice",
    "name-of-a-part",
    "unknown-name",
    "unusable-shape",
    "odd-size",
    # of a model, by poses read off at the robot
    "poses-differ",
    "counts-other-way",
    "zero-elsewhere",
    "coupled",
    "in-radians",
    "in-metres",
    "in-inches",
    "base-elsewhere",
    # of a plan
    "search-stopped",
    "loss-above",
    "blind-above",
    "rho0-above",
    "one-carries",
    "rests-on-one",
    "hardly-needed",
    "half-known",
    "constraint-broken",
    "load-differs",
    "load-too-large",
    "load-outside-cone",
    "load-outside-plane",
    "outside-study",
    "same-information",
    "criterion-ignores",
    "criterion-together",
    "more-experiments",
    "more-configurations",
    "certificate-unknown",
    "claims-unchecked",
    "claims-other-criterion",
    "claims-no-bound",
    "claims-experiments",
    "claims-rho0",
    "claims-rho0-at",
    "claims-promise",
    "claims-nuisance",
    "claims-worst-point",
    "claims-unknown-error",
    "claims-error",
    "claims-covariance",
    "claims-criteria",
    "claims-bound",
    "claims-proved",
    "claims-efficiency",
    # of a proof
    "proof-leaves-out",
    "proof-best-noise",
    "proof-without-errors",
    "proof-without-shared-noise",
    "proof-record-missing",
    "proof-record-other",
    "proof-record-unlike",
    "proof-not-checked",
    # of a motion
    "via-breaks",
    "motion-blocked",
    "no-way",
    "home-blocked",
    "out-of-reach",
]


@dataclass(frozen=True)
class Doubt:
    """What should make one doubt a value, for programs; `wording.worded` makes it a sentence.

    Attributes:
        code: What is the matter.
        about: Names of what is doubted: joints, readings, constraints.
        because: Names of what it is because of, as the experiments that carry a joint.
        numbers: What the sentence says, by name, in SI units and radians.
        unit: Their SI unit where the code leaves it open, as "m" or "rad".
    """

    code: Code
    about: tuple[str, ...] = ()
    because: tuple[str, ...] = ()
    numbers: Mapping[str, float] = field(default_factory=dict, hash=False)
    unit: str = ""


class ElastocalError(Exception):
    """Base of every error a user can cause; carries the exit code of the command line.

    Attributes:
        doubts: What the message says, as values; empty where only the sentence says it.
    """

    exit_code = 2
    doubts: tuple[Doubt, ...] = ()

    def with_doubts(self, *doubts: Doubt) -> Self:
        """This error, which says in codes what its message says."""
        self.doubts = doubts
        return self


class InputError(ElastocalError, ValueError):
    """A value is wrong: unit, name, count, range."""


class StudyError(InputError):
    """A study file is wrong; the message names file, line and key."""


class PlanFileError(InputError):
    """A plan file is wrong or does not belong to the study."""


class MeasurementFileError(InputError):
    """A measurement file is wrong; the message names file, line and column."""


class ModelFileError(InputError):
    """A model file is wrong or does not belong to the robot."""


class PathFileError(InputError):
    """A path file is wrong; the message names file, line and column."""


class EquilibriumError(InputError):
    """A load case has no stable equilibrium with the given compliances."""


class InfeasibleError(ElastocalError):
    """No load case satisfies the constraints; the message names the one in the way."""

    exit_code = 3


class IdentifiabilityError(ElastocalError):
    """The experiments cannot tell some compliances apart; the message names the joints."""

    exit_code = 4
