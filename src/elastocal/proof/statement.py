"""Statement: what a proof of a bound says, in plain numbers that need no robot, study or file.

For every plan of m experiments, M = B + Σ A_iᵀA_i, and every V

    tr(Kᵀ M⁻¹ K) ≥ tr(VᵀK)² / (tr(VᵀBV) + m U),   U ≥ d(x) = |A(x) V|² for all feasible x.

A statement says what A, K, B and V are, which x are feasible and over which box they are searched.
The arm is in its zero configuration: p(q) = exp(ξ_1 q_1) … exp(ξ_n q_n) p(0), where joint i turns
about the line (axis_i, point_i), or slides along axis_i, as they are where all q are zero. What is
on body b moves with the joints 1 … b; markers, load point and constraints are on body n.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray, freeze, frozen, unset


@dataclass(frozen=True)
class ChainJoints:
    """n joints from base to flange, in the zero configuration.

    Attributes:
        names: n names.
        slides: (n,) which slide along their axis; the others turn about it.
        axis: (n, 3) unit vectors, base frame.
        point: (n, 3) points on the axes [m].
        lower: (n,) least values [rad or m].
        upper: (n,) largest values.
    """

    names: tuple[str, ...]
    slides: BoolArray
    axis: Array
    point: Array
    lower: Array
    upper: Array

    def __post_init__(self) -> None:
        freeze(self, "slides", dtype=np.bool_)
        freeze(self, "axis", "point", "lower", "upper")

    def __len__(self) -> int:
        return len(self.names)


@dataclass(frozen=True)
class CarriedSprings:
    """c springs, in the zero configuration.

    Attributes:
        names: c names.
        slides: (c,) which are linear [m/N]; the others are angular [rad/(N·m)].
        body: (c,) number of the body that carries each: 0 is the base.
        axis: (c, 3) unit vectors, base frame.
        point: (c, 3) points on the axes [m].
    """

    names: tuple[str, ...]
    slides: BoolArray
    body: IntArray
    axis: Array
    point: Array

    def __post_init__(self) -> None:
        freeze(self, "slides", dtype=np.bool_)
        freeze(self, "body", dtype=np.int64)
        freeze(self, "axis", "point")

    def __len__(self) -> int:
        return len(self.names)


@dataclass(frozen=True)
class SteadyLoad:
    """One wrench at a point, the same in every experiment.

    Attributes:
        point: (3,) where it acts, on body n in the zero configuration [m].
        force: (3,) [N], base frame.
        moment: (3,) [N·m].
    """

    point: Array
    force: Array
    moment: Array

    def __post_init__(self) -> None:
        freeze(self, "point", "force", "moment")


@dataclass(frozen=True)
class AnyDirection:
    """Every force F = size · basis u with |u| ≤ 1.

    Attributes:
        point: (3,) where it acts [m].
        size: Largest force [N].
        basis: (3, 3), or (3, 2) for forces in a plane; orthonormal columns.
    """

    point: Array
    size: float
    basis: Array

    def __post_init__(self) -> None:
        freeze(self, "point", "basis")


@dataclass(frozen=True)
class InCone:
    """Every force F with |F| ≤ size within an angle of an axis.

    Attributes:
        point: (3,) where it acts [m].
        size: Largest force [N].
        axis: (3,) unit vector, base frame.
        half_angle: Largest angle between force and axis [rad], below π/2.
    """

    point: Array
    size: float
    axis: Array
    half_angle: float

    def __post_init__(self) -> None:
        freeze(self, "point", "axis")


ProofLoad = SteadyLoad | AnyDirection | InCone


@dataclass(frozen=True)
class PointOverPlane:
    """normal · p - offset ≥ 0 for a point p of body n.

    Attributes:
        name: What people call it.
        point: (3,) where p is in the zero configuration [m].
        normal: (3,) base frame.
        offset: [m].
    """

    name: str
    point: Array
    normal: Array
    offset: float

    def __post_init__(self) -> None:
        freeze(self, "point", "normal")


@dataclass(frozen=True)
class DirectionOverPlane:
    """normal · a - offset ≥ 0 for a direction a of body n.

    Attributes:
        name: What people call it.
        axis: (3,) a in the zero configuration.
        normal: (3,) base frame.
        offset: No unit.
    """

    name: str
    axis: Array
    normal: Array
    offset: float

    def __post_init__(self) -> None:
        freeze(self, "axis", "normal")


@dataclass(frozen=True)
class PointByDistance:
    """sign · (Σ w (p - center)² - bound²) ≥ 0 for a point p of body n.

    Attributes:
        name: What people call it.
        point: (3,) where p is in the zero configuration [m].
        center: (3,) base frame [m].
        weights: (3,) w, from 0 to 1.
        sign: 1: at least the bound; -1: at most.
        bound: [m].
    """

    name: str
    point: Array
    center: Array
    weights: Array
    sign: int
    bound: float

    def __post_init__(self) -> None:
        freeze(self, "point", "center", "weights")


ProofConstraint = PointOverPlane | DirectionOverPlane | PointByDistance


@dataclass(frozen=True)
class HeldVariable:
    """A variable that changes nothing, so that one value of it stands for all.

    Attributes:
        variable: Its number.
        because: "flat": rows and constraints do not depend on x_i where the other x are held;
            "base": the whole arm turns about an axis of symmetry of all that counts, so that d
            and the constraints do not depend on q_i where the other q are held.
    """

    variable: int
    because: str


@dataclass(frozen=True)
class HalvedVariable:
    """A symmetry q → signs · q + shifts of all that counts, and what it is used for.

    Attributes:
        variable: Number of the variable of which half of the range is left.
        signs: (n,) 1 or -1.
        shifts: (n,) 0 or π [rad].
    """

    variable: int
    signs: Array
    shifts: Array

    def __post_init__(self) -> None:
        freeze(self, "signs", "shifts")


@dataclass(frozen=True)
class Statement:
    """What is proved, or to be proved.

    Attributes:
        name: Of the study.
        criterion: Name of the criterion whose loss is bounded.
        study_sha256: Hash of the study file's text.
        version: Of the program that made the statement.
        joints: The n joints.
        springs: The c springs.
        make: (c, p) compliances of the springs for one of each unknown.
        unknowns: p names.
        markers: (M, 3) where the markers are in the zero configuration [m].
        sigma: Standard deviation of one coordinate of one deflection [m].
        sigma_turn: That of one component of the rotation [rad]; None if it is not read.
        load: Which wrenches may act.
        constraints: C constraints besides the limits of the joints.
        V: (p, r) the V of the bound.
        K: (p, r) what the loss asks for: it is at least tr(Kᵀ M⁻¹ K), and beyond that what no
            plan makes smaller.
        B: (p, p) information there is anyway.
        count: Number of experiments m.
        left_out: What the study asks for besides and the statement does not: it is only weaker.
        mix: (n, n) q = mix @ x: lower triangular, of 1, 0 and -1, with 1 on the diagonal.
        root: (2, n) the box that is searched, in x.
        limited: (n,) whether the limits of joint i count beyond the root: only where row i of
            `mix` has more than one entry, and the joint turns by less than 2π.
        held: Variables that are held; their root has no width. One that is held because rows are
            flat is taken to have its whole range where the root of another one is made of it.
        halved: Symmetries that were used, in order: each leaves the halves of those before it.
        points: (n,) points per variable of the tables of third derivatives; empty: none were made.
        largest: U; None as long as nothing is proved.
        rho0: The bound on the loss that follows; likewise.
        witnesses: (W, n + 3) feasible load cases: x, then the force [N].
    """

    name: str
    criterion: str
    study_sha256: str
    version: str
    joints: ChainJoints
    springs: CarriedSprings
    make: Array
    unknowns: tuple[str, ...]
    markers: Array
    sigma: float
    sigma_turn: float | None
    load: ProofLoad
    constraints: tuple[ProofConstraint, ...]
    V: Array
    K: Array
    B: Array
    count: int
    left_out: tuple[str, ...] = ()
    mix: Array = field(default_factory=unset)
    root: Array = field(default_factory=unset)
    limited: BoolArray = field(default_factory=lambda: frozen([], np.bool_))
    held: tuple[HeldVariable, ...] = ()
    halved: tuple[HalvedVariable, ...] = ()
    points: IntArray = field(default_factory=lambda: frozen([], np.int64))
    largest: float | None = None
    rho0: float | None = None
    witnesses: Array = field(default_factory=unset)

    def __post_init__(self) -> None:
        n = len(self.joints)
        freeze(self, "make", "V", "K", "B", markers=np.reshape(self.markers, (-1, 3)))
        freeze(self, mix=self.mix if np.size(self.mix) else np.eye(n))
        limits = [self.joints.lower, self.joints.upper]
        freeze(self, root=self.root if np.size(self.root) else limits)
        limited = self.limited if np.size(self.limited) else np.zeros(n)
        freeze(self, limited=limited, dtype=np.bool_)
        freeze(self, "points", dtype=np.int64)
        freeze(self, witnesses=np.reshape(self.witnesses, (-1, n + 3)))

    @property
    def active(self) -> IntArray:
        """(a,) variables whose root has a width."""
        return np.flatnonzero(self.root[1] > self.root[0])

    @property
    def seen(self) -> Array:
        """(c, r) rows of V of the springs that the unknowns make."""
        return np.asarray(self.make @ self.V)

    @property
    def directions(self) -> Array | None:
        """(3, k) forces that u of norm at most 1 combines; None if the load is steady.

        Those of a cone are all its size allows.
        """
        if isinstance(self.load, SteadyLoad):
            return None
        basis = self.load.basis if isinstance(self.load, AnyDirection) else np.eye(3)
        return np.asarray(self.load.size * basis)
