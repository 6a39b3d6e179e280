"""The loaded equilibrium against its energy, differences, limits, and itself one by one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from elastocal.arrays import Array
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.deflections import deflection_and_gradient, loaded_deflection, markers_at
from elastocal.elastic.equilibrium import equilibrium, linearise
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import deflection
from elastocal.elastic.springs import VirtualJoints, joint_springs
from elastocal.errors import EquilibriumError
from elastocal.robot.chain import Joint, Robot, T_body_joint, Tool, transform
from elastocal.robot.posture import Posture
from tests.arms import chain_with_springs, random_chain, random_springs, random_tool, with_masses

chains = st.tuples(st.integers(0, 2**32 - 1), st.lists(st.booleans(), min_size=1, max_size=6))
reproducible = settings(max_examples=30)
GENTLE = 0.02  # compliance times load: displacements of some hundredths of a radian


def random_arm(rng: np.random.Generator, slides: list[bool], *, heavy: bool = True) -> ElasticArm:
    """Springs in all joints and two elsewhere, weights, two markers."""
    robot = random_chain(rng, slides)
    if heavy:
        robot = with_masses(rng, robot)
    springs = random_springs(rng, robot)
    gravity = rng.normal(size=3) if heavy else np.zeros(3)
    return ElasticArm(robot, springs, random_tool(rng, 2), gravity)


def random_cases(rng: np.random.Generator, arm: ElasticArm, count: int) -> LoadCases:
    q = rng.uniform(-2.0, 2.0, (count, len(arm.robot.joints)))
    return LoadCases(q, rng.normal(size=(count, 6)))


def potential(
    arm: ElasticArm, compliance: Array, q: Array, force: Array
) -> Callable[[Array], float]:
    """Energy of springs, weights and a constant force over θ; the chain is that of the tests."""
    robot, virtual, actuated = chain_with_springs(arm.robot, _outside(arm.springs))
    outside = arm.springs.joint < 0
    own = [actuated[j] for j in arm.springs.joint[~outside]]
    bodies = [actuated[mass.body - 1] + 1 for mass in arm.robot.masses]
    # The joints of that chain have the frames in which centres of mass are given.
    centers = [
        (T_body_joint(robot, body) @ [*mass.center, 1.0])[:3]
        for mass, body in zip(arm.robot.masses, bodies, strict=True)
    ]

    def energy(theta: Array) -> float:
        joints = np.zeros((1, len(robot.joints)))
        joints[0, actuated] = q
        joints[0, virtual] += theta[outside]
        joints[0, own] += theta[~outside]
        posture = Posture(robot, joints)
        value = 0.5 * float(np.sum(theta**2 / compliance))
        value -= float(force @ posture.point(arm.tool.load_point)[:, 0])
        for mass, body, center in zip(arm.robot.masses, bodies, centers, strict=True):
            value -= mass.mass * float(arm.gravity @ posture.point(center, body)[:, 0])
        return value

    return energy


def _outside(springs: VirtualJoints) -> VirtualJoints:
    keep = springs.joint < 0
    return VirtualJoints(
        tuple(n for n, k in zip(springs.names, keep, strict=True) if k),
        springs.body[keep],
        springs.axis[keep],
        springs.origin[keep],
        springs.prismatic[keep],
    )


@settings(max_examples=12)
@given(st.tuples(st.integers(0, 2**32 - 1), st.lists(st.booleans(), min_size=1, max_size=4)))
def test_the_energy_is_smallest_at_the_equilibrium(chain: tuple[int, list[bool]]) -> None:
    """Any springs and weights, a force: a general minimiser finds the same place."""
    from scipy.optimize import minimize

    rng = np.random.default_rng(chain[0])
    arm = random_arm(rng, chain[1])
    p = len(arm.springs)
    compliance = GENTLE * rng.uniform(0.2, 1.0, p)
    cases = random_cases(rng, arm, 1)
    cases = LoadCases(cases.q, cases.wrench * [1, 1, 1, 0, 0, 0])
    found = equilibrium(arm, compliance, cases).displacement[0]
    scale = np.sqrt(compliance)  # the springs' energy is then that of a sphere

    energy_of = potential(arm, compliance, cases.q[0], cases.wrench[0, :3])
    start = energy_of(np.zeros(p))

    def energy(x: Array) -> float:
        return energy_of(scale * x) - start

    options = {"gtol": 1e-9}
    best = minimize(energy, np.zeros(p), jac="3-point", method="BFGS", options=options)
    # A minimiser that knows only values is good to the root of rounding.
    np.testing.assert_allclose(found / scale, best.x, atol=1e-6)
    assert energy(found / scale) <= energy(best.x) + 1e-14


@reproducible
@given(chains)
def test_forces_balance_at_the_equilibrium(chain: tuple[int, list[bool]]) -> None:
    """Forces and moments: θ = k ∘ y with y from virtual work, differences of the positions."""
    rng = np.random.default_rng(chain[0])
    arm = random_arm(rng, chain[1])
    p = len(arm.springs)
    compliance = GENTLE * rng.uniform(0.2, 1.0, p)
    cases = random_cases(rng, arm, 1)
    theta = equilibrium(arm, compliance, cases).displacement[0]
    step = 1e-5
    effort = np.zeros(p)
    for j in range(p):
        shift = np.zeros(p)
        shift[j] = step
        ahead, behind = (
            Posture(arm.chain, arm.bent(cases.q, (theta + s)[None])) for s in (shift, -shift)
        )
        moved = ahead.point(arm.tool.load_point) - behind.point(arm.tool.load_point)
        effort[j] = cases.wrench[0, :3] @ moved[:, 0]
        turned = ahead.bodies[-1][:3, :, 0].T @ behind.bodies[-1][:3, :, 0]
        spin = 0.5 * np.array(
            [turned[2, 1] - turned[1, 2], turned[0, 2] - turned[2, 0], turned[1, 0] - turned[0, 1]]
        )
        effort[j] += cases.wrench[0, 3:] @ spin
        for mass in arm.chain.masses:
            fall = ahead.point(mass.center, mass.body) - behind.point(mass.center, mass.body)
            effort[j] += mass.mass * arm.gravity @ fall[:, 0]
    np.testing.assert_allclose(theta, compliance * effort / (2 * step), atol=1e-9)


@reproducible
@given(chains)
def test_the_slope_is_the_derivative_in_the_compliances(chain: tuple[int, list[bool]]) -> None:
    """At the equilibrium, and of the marker positions: against central differences."""
    rng = np.random.default_rng(chain[0])
    arm = random_arm(rng, chain[1])
    p = len(arm.springs)
    compliance = GENTLE * rng.uniform(0.5, 1.0, p)
    cases = random_cases(rng, arm, 2)
    at = equilibrium(arm, compliance, cases)
    state = linearise(arm, compliance, cases.q, cases.wrench, at.displacement)
    np.testing.assert_allclose(state.step, 0.0, atol=1e-13)
    np.testing.assert_allclose(state.markers, markers_at(arm, cases.q, at.displacement), atol=1e-14)
    for j in range(p):
        h = np.zeros(p)
        h[j] = 1e-5
        ahead, behind = (equilibrium(arm, compliance + s, cases).displacement for s in (h, -h))
        np.testing.assert_allclose(state.slope[:, :, j], (ahead - behind) / 2e-5, atol=1e-6)
        moved = markers_at(arm, cases.q, ahead) - markers_at(arm, cases.q, behind)
        gradient = np.einsum("nmp,np->nm", state.velocity, state.slope[:, :, j])
        np.testing.assert_allclose(gradient, moved / 2e-5, atol=1e-5)


@reproducible
@given(chains)
def test_small_loads_give_the_linear_model(chain: tuple[int, list[bool]]) -> None:
    """The difference to the regressor falls as the square of the load."""
    rng = np.random.default_rng(chain[0])
    arm = random_arm(rng, chain[1], heavy=False)
    compliance = GENTLE * rng.uniform(0.5, 1.0, len(arm.springs))
    cases = random_cases(rng, arm, 2)
    off = []
    for load in (1e-2, 1e-3):
        small = LoadCases(cases.q, load * cases.wrench)
        linear = deflection(arm, compliance, small)[:, :-3]
        off.append(np.abs(loaded_deflection(arm, compliance, small) - linear).max())
    # Sliding joints alone are linear: what is left there is rounding of positions of metres.
    assert off[1] <= 0.011 * off[0] + 1e-14
    assert off[0] <= 1e-2


@reproducible
@given(chains)
def test_a_batch_is_its_members_one_by_one(chain: tuple[int, list[bool]]) -> None:
    """Also with another arm for every load case."""
    rng = np.random.default_rng(chain[0])
    arm = random_arm(rng, chain[1])
    each = GENTLE * rng.uniform(0.2, 1.0, (5, len(arm.springs)))
    cases = random_cases(rng, arm, 5)
    together = equilibrium(arm, each, cases)
    same = equilibrium(arm, each[0], cases)
    positions = loaded_deflection(arm, each, cases)
    for i in range(5):
        one = LoadCases(cases.q[i : i + 1], cases.wrench[i : i + 1])
        alone = equilibrium(arm, each[i], one)
        np.testing.assert_allclose(together.displacement[i], alone.displacement[0], atol=1e-14)
        np.testing.assert_allclose(together.stability[i], alone.stability[0], atol=1e-12)
        alone = equilibrium(arm, each[0], one)
        np.testing.assert_allclose(same.displacement[i], alone.displacement[0], atol=1e-14)
        np.testing.assert_allclose(
            positions[i], loaded_deflection(arm, each[i], one)[0], atol=1e-14
        )
    assert together.converged.all()


def test_thousands_of_load_cases_are_evaluated_in_chunks() -> None:
    rng = np.random.default_rng(0)
    arm = random_arm(rng, [False, True, False])
    cases = random_cases(rng, arm, 5000)
    compliance = np.full(len(arm.springs), 1e-3)
    found = loaded_deflection(arm, compliance, cases)
    last = LoadCases(cases.q[-3:], cases.wrench[-3:])
    np.testing.assert_allclose(found[-3:], loaded_deflection(arm, compliance, last), atol=1e-14)


def test_no_load_cases_are_no_error() -> None:
    arm = random_arm(np.random.default_rng(0), [False, True])
    none = LoadCases(np.zeros((0, 2)), np.zeros((0, 6)))
    assert loaded_deflection(arm, np.full(4, 1e-3), none).shape == (0, 6)


@reproducible
@given(chains)
def test_the_chain_with_springs_is_the_robot_while_nothing_bends(
    chain: tuple[int, list[bool]],
) -> None:
    rng = np.random.default_rng(chain[0])
    arm = random_arm(rng, chain[1])
    q = rng.uniform(-3.0, 3.0, (3, len(arm.robot.joints)))
    still = arm.bent(q, np.zeros((3, len(arm.springs))))
    ours, rigid = Posture(arm.chain, still), Posture(arm.robot, q)
    np.testing.assert_allclose(ours.bodies[-1], rigid.bodies[-1], atol=1e-13)
    for mine, theirs in zip(arm.chain.masses, arm.robot.masses, strict=True):
        np.testing.assert_allclose(
            ours.point(mine.center, mine.body), rigid.point(theirs.center, theirs.body), atol=1e-13
        )


def pendulum(*, length: float = 1.0) -> ElasticArm:
    """An upright rod on a spring at its foot, turning about y."""
    robot = Robot(
        "rod", (Joint("J1", np.eye(4), np.array([0.0, 1.0, 0.0])),), transform(None, [0, 0, length])
    )
    tool = Tool("tip", np.zeros(3), np.zeros((1, 3)), ("tip",))
    return ElasticArm(robot, joint_springs(robot), tool)


@pytest.mark.parametrize("load", [0.1, 0.5, 0.9, 0.99])
def test_an_upright_rod_bends_in_closed_form(load: float) -> None:
    """Weight P on a rod of length 1 with stiffness 1 and a side force: θ = P sin θ + S cos θ.

    Its stability is 1 - P cos θ + S sin θ; at P = 1 without side force it buckles.
    """
    side = 1e-3
    case = LoadCases(np.zeros((1, 1)), np.array([[side, 0, -load, 0, 0, 0]]))
    found = equilibrium(pendulum(), np.ones(1), case)
    theta = found.displacement[0, 0]
    assert theta == pytest.approx(load * np.sin(theta) + side * np.cos(theta), rel=1e-12)
    exact = 1.0 - load * np.cos(theta) + side * np.sin(theta)
    assert found.stability[0] == pytest.approx(exact, rel=1e-9)
    tip = loaded_deflection(pendulum(), np.ones(1), case)[0]
    np.testing.assert_allclose(tip, [np.sin(theta), 0.0, np.cos(theta) - 1.0], atol=1e-14)


@pytest.mark.parametrize("load", [1.0, 1.001, 3.0, 1e6])
def test_a_rod_that_buckles_is_refused(load: float) -> None:
    """Without a side force Newton rests upright, where the rod is not stable any more."""
    good = [0.0, 0.0, -0.5, 0.0, 0.0, 0.0]
    case = LoadCases(np.zeros((2, 1)), np.array([good, [0, 0, -load, 0, 0, 0]]))
    found = equilibrium(pendulum(), np.ones(1), case)
    assert found.stability[0] == pytest.approx(0.5)
    with pytest.raises(EquilibriumError, match="load case 2 has no stable equilibrium"):
        loaded_deflection(pendulum(), np.ones(1), case)


def test_compliances_in_the_wrong_unit_are_refused_without_a_warning() -> None:
    """A factor of a million: the iteration must end, and say so."""
    rng = np.random.default_rng(2)
    for seed in range(20):
        rng = np.random.default_rng(seed)
        arm = random_arm(rng, [False, False, True, False], heavy=False)
        cases = random_cases(rng, arm, 3)
        with pytest.raises(EquilibriumError):
            loaded_deflection(arm, np.full(len(arm.springs), 1e4), cases)


def test_zero_compliance_is_rigid() -> None:
    rng = np.random.default_rng(3)
    arm = random_arm(rng, [False, True, False])
    cases = random_cases(rng, arm, 4)
    np.testing.assert_array_equal(loaded_deflection(arm, np.zeros(5), cases), 0.0)


def test_weights_cancel_to_first_order() -> None:
    """A deflection is loaded minus unloaded, both under the weight of the links."""
    rng = np.random.default_rng(4)
    arm = random_arm(rng, [False, False, True])
    cases = random_cases(rng, arm, 4)
    weightless = replace(arm, gravity=np.zeros(3))
    assert arm.sags
    assert not weightless.sags
    compliance = np.full(5, 1e-4)
    with_, without = (loaded_deflection(a, compliance, cases) for a in (arm, weightless))
    assert 1e-9 < np.abs(with_ - without).max() < 0.02 * np.abs(without).max()


@pytest.mark.parametrize("heavy", [True, False])
@pytest.mark.parametrize("slides", [[False] * 3, [False, True, False, False]])
def test_gradients_of_deflections_are_differences(slides: list[bool], heavy: bool) -> None:
    """Loaded minus idle, both under the weight of the links if there is one."""
    rng = np.random.default_rng(3)
    arm = random_arm(rng, slides, heavy=heavy)
    assert arm.sags == heavy
    cases = random_cases(rng, arm, 4)
    k = 0.01 * rng.uniform(0.5, 1.5, len(arm.springs))
    value, slope = deflection_and_gradient(arm, k, cases)
    np.testing.assert_allclose(value, loaded_deflection(arm, k, cases), atol=1e-15)
    for j in range(len(k)):
        h = 1e-4 * k[j] * np.eye(len(k))[j]
        change = loaded_deflection(arm, k + h, cases) - loaded_deflection(arm, k - h, cases)
        np.testing.assert_allclose(
            slope[:, :, j], change / (2.0 * h[j]), atol=1e-8 * np.abs(slope).max()
        )
