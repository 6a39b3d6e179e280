"""What can go wrong, as types.

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


class ElastocalError(Exception):
    """Base of every error a user can cause; carries the exit code of the command line."""

    exit_code = 2


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
