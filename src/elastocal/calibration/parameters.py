"""Parameters: the unknowns of a fit to absolute readings, in blocks, and what was known of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray, freeze, frozen, unset
from elastocal.calibration.arm_model import ArmModel, State, small_bases
from elastocal.measuring.positions import Positions
from elastocal.robot.geometry import group_of
from elastocal.robot.joint_kinds import JointKind, kind_of
from elastocal.robot.rotations import from_rotation_vectors

BASE, TOOL, PROBE, COMPLIANCE, PAYLOAD = "base", "tool", "probe", "compliance", "payload"
COMPENSATOR = "compensator"
GEOMETRY_PRIOR = 2e-3
"""Standard uncertainty of a geometric error before anything is measured [rad or m].

Only combinations that readings cannot tell apart rest on it. Source: ours; robots are found to be
off by some tenths of a millimetre and milliradian, and up to a few by zeros of joints.
"""
TURNED = 2e-2
"""Standard uncertainty of what a compensator turns its joint at its largest lever [rad]; ours."""
_SOMEWHERE = 1.0  # m from where a reflector is thought to be; holds what a base does as well
_NOTHING_KNOWN = 1e-3  # rad/(N·m), m/N: a thousand times what joints of arms have


@dataclass(frozen=True)
class Parameters:
    """U unknowns, in the order base, tool, probe, geometry, compliance, compensator, payload.

    Attributes:
        names: What they are called.
        block: The block of each: a name above, or a group of geometric errors.
        turns: (U,) whether each is an angle, or a compliance of a spring that turns.
        stations: Number of stations S, with six unknowns each.
        targets: (M, K + 1) whether a mounting's reflectors, and last its probe, were read.
        compliances: Number p of compliances.
        geometry: Number G of geometric errors.
        hung: The payloads that are unknown.
        rows: (E, U) what was known before, in units of its uncertainty.
        mean: (G + p + C,) what was expected of geometric errors, compliances and compensators.
        compensators: Number C of compensators.
        held: (U,) unknowns that are known exactly: bases and tools nobody asks for.
    """

    names: tuple[str, ...]
    block: tuple[str, ...]
    turns: tuple[bool, ...]
    stations: int
    targets: IntArray
    geometry: int
    compliances: int
    hung: tuple[int, ...] = ()
    rows: Array = field(default_factory=unset)
    mean: Array = field(default_factory=unset)
    held: BoolArray = field(default_factory=lambda: frozen([], np.bool_))
    compensators: int = 0

    def __post_init__(self) -> None:
        mean = self.mean if self.mean.size else np.zeros(self.inner)
        held = self.held if self.held.size else np.zeros(len(self.names))
        freeze(self, "rows", mean=mean)
        freeze(self, held=held, dtype=np.bool_)
        freeze(self, "targets", dtype=np.int64)

    def __len__(self) -> int:
        return len(self.names)

    @property
    def kinds(self) -> tuple[JointKind, ...]:
        """Whether each turns or slides."""
        return tuple(kind_of(not turns) for turns in self.turns)

    def base(self, station: IntArray) -> IntArray:
        """(R, 6) unknowns of the bases of stations (R,)."""
        return np.asarray(6 * np.asarray(station)[:, None] + np.arange(6))

    @property
    def _tool(self) -> IntArray:
        """(M, K + 1) first unknown of each reflector and probe."""
        before = np.cumsum(np.append(0, self.targets.ravel()))[:-1].reshape(self.targets.shape)
        return np.asarray(6 * self.stations + 3 * before)

    def marker(self, mounting: int, target: int) -> IntArray:
        """(3,) unknowns of a reflector."""
        return np.asarray(self._tool[mounting, target] + np.arange(3))

    def probe(self, mounting: int) -> IntArray:
        """(3,) unknowns of the orientation of a probe."""
        return self.marker(mounting, self.targets.shape[1] - 1)

    @property
    def arm(self) -> int:
        """Number of the first unknown of the arm itself."""
        return int(6 * self.stations + 3 * self.targets.sum())

    @property
    def inner(self) -> int:
        """Number of unknowns of the arm itself, payloads aside: G + p + C."""
        return self.geometry + self.compliances + self.compensators

    def inside(self, payload: int) -> IntArray:
        """Unknowns that move the flange where a payload (-1: none) hangs on it."""
        first, many = self.arm, self.inner
        found = np.arange(first, first + many)
        if payload not in self.hung:
            return found
        return np.append(found, first + many + 4 * self.hung.index(payload) + np.arange(4))

    def shown(self, u: int) -> tuple[float, str]:
        """Factor from SI, and unit, in which an unknown is shown."""
        kind, block = self.kinds[u], self.block[u]
        if block == TOOL:
            return 1e3, "mm"
        if block == PAYLOAD:
            return 1.0, "kg" if self.names[u].startswith("mass") else "kg·m"
        if block == COMPENSATOR:
            return 1.0, "rad/m²"
        if block == COMPLIANCE:
            return 1e6, f"µ{kind.compliance}"
        return 1e3, "mrad" if kind.unit == "rad" else "mm"

    def of(self, *blocks: str) -> IntArray:
        """Numbers of the unknowns of some blocks."""
        return np.flatnonzero([block in blocks for block in self.block])


def parameters_of(
    model: ArmModel,
    positions: Positions,
    compliance_prior: Array | None = None,
    mean: Array | None = None,
    geometry_prior: float = GEOMETRY_PRIOR,
    held: tuple[str, ...] = (),
) -> Parameters:
    """The unknowns of a model that readings may tell.

    Args:
        model: Arm with its geometric errors and compliances.
        positions: Readings: stations, mountings, payloads.
        compliance_prior: (p, p) information on the compliances that there is before.
        mean: (p,) what was expected of them; zero if not given.
        geometry_prior: Standard uncertainty of each geometric error [rad or m].
        held: Blocks that are known exactly: "base" if stations read in the frame of the base,
            "tool" if reflectors are where they are thought to be.
    """
    tool = positions.tool
    targets = np.zeros((len(positions.mountings), len(tool.markers) + 1), dtype=np.int64)
    targets[positions.mounting[positions.case], positions.marker] = 1
    names, block, turns = [], [], []

    def add(name: str, of: str, turn: bool) -> None:
        names.append(name)
        block.append(of)
        turns.append(turn)

    for station in positions.stations:
        of = f" of {station}" if len(positions.stations) > 1 else ""
        for i, axis in enumerate("xyzxyz"):
            add(f"base{of} {'turn ' if i > 2 else ''}{axis}", BASE, i > 2)
    for m, k in np.argwhere(targets).tolist():
        mounting = f" of {positions.mountings[m]}" if len(positions.mountings) > 1 else ""
        probe = k == len(tool.markers)
        what = "probe" if probe else tool.marker_names[k]
        for axis in "xyz":
            add(
                f"{what}{mounting} {'turn ' if probe else ''}{axis}",
                PROBE if probe else TOOL,
                probe,
            )
    groups = group_of(model.errors, model.robot)
    for name, kind, group in zip(model.errors.names, model.errors.kinds, groups, strict=True):
        add(name, group, kind.unit == "rad")
    for name, kind in zip(model.compliances.names, model.compliances.kinds, strict=True):
        add(name, COMPLIANCE, kind.unit == "rad")
    for compensator in model.compensators:
        add(f"compensator {compensator.name}", COMPENSATOR, True)
    hung = tuple(
        i
        for i in sorted(set(positions.payload.tolist()) - {-1})
        if model.payloads[i].mass_error > 0.0 or model.payloads[i].center_error > 0.0
    )
    for i in hung:
        for what in ("mass", "moment x", "moment y", "moment z"):
            add(f"{what} of {model.payloads[i].name}", PAYLOAD, False)
    p, g, c = len(model.compliances), len(model.errors), len(model.compensators)
    found = Parameters(
        tuple(names),
        tuple(block),
        tuple(turns),
        len(positions.stations),
        targets,
        g,
        p,
        hung,
        mean=np.concatenate([np.zeros(g), np.zeros(p) if mean is None else mean, np.zeros(c)]),
        held=np.isin(block, (*held, *([PROBE] if TOOL in held else []))),
        compensators=c,
    )
    strength = [
        TURNED / max(float(np.abs(one.lever(positions.cases.q[:, one.joint])).max()), 1e-9)
        for one in model.compensators
    ]
    return _with_prior(found, model, compliance_prior, geometry_prior, strength)


def _with_prior(
    parameters: Parameters,
    model: ArmModel,
    compliance_prior: Array | None,
    geometry_prior: float,
    strength: Sequence[float],
) -> Parameters:
    u, a = len(parameters), parameters.arm
    g, p = parameters.geometry, parameters.compliances
    tool, hung = parameters.of(TOOL), 4 * len(parameters.hung)
    m = parameters.inner
    rows = np.zeros((m + hung + len(tool), u))
    rows[m + hung :, tool] = np.eye(len(tool)) / _SOMEWHERE
    rows[g + p : m, a + g + p : a + m] = np.diag(1.0 / np.array(strength))
    rows[:g, a : a + g] = np.eye(g) / geometry_prior
    known: Array = np.eye(p) / _NOTHING_KNOWN
    if compliance_prior is not None:
        known = np.asarray(np.linalg.cholesky(compliance_prior + known**2).T, dtype=float)
    rows[g : g + p, a + g : a + g + p] = known
    for n, i in enumerate(parameters.hung):
        load, at = model.payloads[i], slice(m + 4 * n, m + 4 * n + 4)
        mass = max(load.mass_error, 1e-9 * max(load.mass, 1.0))
        arm = max(load.center_error, 1e-9) * max(load.mass, 1e-9)
        own = np.zeros((4, 4))
        own[0, 0], own[1:, 1:] = 1.0 / mass, np.eye(3) / arm
        own[1:, 0] = -load.center / arm
        rows[at, a + at.start : a + at.stop] = own
    return replace(parameters, rows=rows)


def from_prior(parameters: Parameters, model: ArmModel, state: State) -> Array:
    """(E,) how far a state is from what was known before, in units of its uncertainty."""
    values = np.zeros(len(parameters))
    a, m = parameters.arm, parameters.inner
    inner = np.concatenate([state.geometry, state.compliance, state.compensator])
    values[a : a + m] = inner - parameters.mean
    for mounting, k in np.argwhere(parameters.targets[:, :-1]).tolist():
        moved = state.markers[mounting, k] - model.tool.markers[k]
        values[parameters.marker(mounting, k)] = moved
    for n, i in enumerate(parameters.hung):
        load = model.payloads[i]
        thought = np.append(load.mass, load.mass * load.center)
        values[a + m + 4 * n : a + m + 4 * n + 4] = state.payload[i] - thought
    return np.asarray(parameters.rows @ values)


def normal_matrix(parameters: Parameters, rows: Array) -> Array:
    """(U, U) information of rows over the noise (3R, U) and of what was known before.

    What is held has 1 for itself and shares nothing, so that the matrix has an inverse.
    """
    normal = rows.T @ rows + parameters.rows.T @ parameters.rows
    normal[parameters.held] = normal[:, parameters.held] = 0.0
    normal[parameters.held, parameters.held] = 1.0
    return np.asarray(normal)


def step_of(parameters: Parameters, state: State, values: Array) -> State:
    """The small step of a state that unknowns `values`, (U,), make."""
    s, a = parameters.stations, parameters.arm
    g, p = parameters.geometry, parameters.compliances
    markers, probe = np.zeros_like(state.markers), np.tile(np.eye(3), (len(state.probe), 1, 1))
    for m, k in np.argwhere(parameters.targets).tolist():
        own = values[parameters.marker(m, k)]
        if k == parameters.targets.shape[1] - 1:
            probe[m] = from_rotation_vectors(own[None])[0]
        else:
            markers[m, k] = own
    payload = np.zeros_like(state.payload)
    for n, i in enumerate(parameters.hung):
        first = a + parameters.inner + 4 * n
        payload[i] = values[first : first + 4]
    base = small_bases(values[: 6 * s].reshape(s, 6), state.base)
    compliance = values[a + g : a + g + p]
    held = values[a + g + p : a + parameters.inner]
    return State(base, markers, probe, values[a : a + g], compliance, payload, held)
