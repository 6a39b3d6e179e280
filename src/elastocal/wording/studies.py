"""What looks odd in a study."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from elastocal.errors import Code, Doubt
from elastocal.wording.lists import listed
from elastocal.wording.numbers import described, length, shown

_NOT_WATCHED = {
    "ignored": "left out by the study",
    "stands-on-it": "the link stands on it",
    "below-it": "the link is below it",
    "always-touch": "nearly always touch",
    "always-near": "nearly always nearer than the margin",
    "always-close": "never farther apart than twice the margin",
    "neighbours": "neighbours",
    "tracker-head": "the head of the tracker stands in it",
}


def _mm(doubt: Doubt, name: str) -> str:
    return f"{1e3 * doubt.numbers[name]:g} mm"


def _small_angles(doubt: Doubt) -> str:
    factor, unit = shown("rad")
    return (
        f"all angles of test pose {doubt.about[0]!r} are below "
        f"{factor * doubt.numbers['below']:.2g}{unit}: were radians meant?"
    )


def _no_task(doubt: Doubt) -> str:
    joints = "this joint" if len(doubt.about) == 1 else "these joints"
    return (
        f"{', '.join(doubt.about)}: no test pose is deflected through {joints}, so the plan spends "
        "no effort there that it can avoid"
    )


def _rigid_at_test_pose(doubt: Doubt) -> str:
    is_, its = ("is", "its") if len(doubt.about) == 1 else ("are", "their")
    poses = "test pose" if len(doubt.because) == 1 else "test poses"
    unit = _MILLIONTHS.get(doubt.unit, doubt.unit)
    adds = " and ".join(
        f"of {name} adds up to {length(_STEP * move)}" for name, move in doubt.numbers.items()
    )
    return (
        f"{', '.join(doubt.about)} {is_} taken as rigid, but bent at {poses} "
        f"{', '.join(map(repr, doubt.because))}: {its} error comes on top of ρ0, every 0.1 {unit} "
        f"{adds} there; a second campaign can identify what this one leaves out"
    )


def _chain_as_capsules(doubt: Doubt) -> str:
    least, most = (f"{1e3 * doubt.numbers[name]:.3g}" for name in ("least", "most"))
    radius = least if least == most else f"{least} to {most}"
    whose = f"no shape was read of {listed(doubt.about)}" if doubt.about else "no shapes are given"
    return (
        f"{whose}: watched as capsules from joint to joint, {radius} mm in radius; "
        "constraints: {collision: {link_radius_mm: …}} says how thick"
    )


def _odd_size(doubt: Doubt) -> str:
    size, reach = doubt.numbers["size"], doubt.numbers["reach"]
    far = f"{reach:.3g} m"
    link, has = ("link", "has a shape") if len(doubt.about) == 1 else ("links", "have shapes")
    names = listed([repr(name) for name in doubt.about])
    if size > reach:
        about = "up to " * (len(doubt.about) > 1) + f"{size:.3g} m large"
        mend = 'are they millimetres, or is <mesh scale="0.001 0.001 0.001"> missing?'
    else:
        about = "of " + "no more than " * (len(doubt.about) > 1) + described(size, "m")
        mend = "is a mesh scaled that is in metres?"
    return (
        f"{link} {names} {has} {about}, and the robot reaches {far}: robot files "
        f"are in metres; {mend}"
    )


_STEP = 1e-7  # of a compliance that is left out [rad/(N·m), m/N]
_MILLIONTHS = {"rad/(N·m)": "µrad/(N·m)", "m/N": "µm/N"}


def _coarse(doubt: Doubt) -> str:
    if doubt.unit == "rad":
        return (
            f"sigma of rotations is {1e3 * doubt.numbers['sigma']:.3g} mrad: were microradians "
            "meant? 0.01° are 0.175 mrad"
        )
    return (
        f"sigma is {_mm(doubt, 'sigma')} per coordinate: were micrometres meant? A laser tracker "
        "has about 0.03 mm"
    )


SENTENCES: Mapping[Code, Callable[[Doubt], str]] = {
    "small-tool": lambda doubt: (
        f"tool {doubt.about[0]!r} is no larger than {_mm(doubt, 'size')}: were metres meant?"
    ),
    "large-tool": lambda doubt: (
        f"tool {doubt.about[0]!r} reaches {doubt.numbers['size']:.4g} m from the flange, which is "
        "larger than the arm"
    ),
    "small-angles": _small_angles,
    "small-pose-force": lambda doubt: (
        f"the force at test pose {doubt.about[0]!r} is only {doubt.numbers['force']:g} N: were "
        "kilonewtons meant?"
    ),
    "pose-below-floor": lambda doubt: (
        f"the tool at test pose {doubt.about[0]!r} is {_mm(doubt, 'by')} below the floor: is the "
        "floor elsewhere, as in constraints: {floor: {z_mm: -300}}?"
    ),
    "robot-below-floor": lambda doubt: (
        f"{listed(doubt.about)}, on which the robot stands, "
        f"{'is' if len(doubt.about) == 1 else 'are'} wholly below the floor, which is "
        f"{_mm(doubt, 'height')} above the origin of the base: is it meant to be below, as in "
        "constraints: {floor: {z_mm: -300}}?"
    ),
    "small-force": lambda doubt: (
        f"the calibration force is only {doubt.numbers['force']:g} N: were kilonewtons meant?"
    ),
    "coarse-sigma": _coarse,
    "near-tracker": lambda doubt: (
        f"the tracker stands {1e3 * doubt.numbers['distance']:.3g} mm from the origin of the base: "
        "were metres meant?"
    ),
    "short-range": lambda doubt: f"{doubt.about[0]}: were metres meant?",
    "small-obstacle": lambda doubt: (
        f"obstacle {doubt.about[0]!r} is no larger than {_mm(doubt, 'size')}: were metres meant?"
    ),
    "thin-links": lambda doubt: (
        f"links are as thin as {_mm(doubt, 'radius')} in radius: were metres meant?"
    ),
    "no-task": _no_task,
    "taken-as-rigid": lambda doubt: (
        f"{', '.join(doubt.about)}: taken as rigid, not identified by this study"
    ),
    "criterion-renamed": lambda doubt: (
        "criterion {0} is that of the paper's Table 1, the largest standard error of a compliance; "
        "what version 0.1.0 called {0} is {1!r}".format(*doubt.about)
    ),
    "rigid-at-test-pose": _rigid_at_test_pose,
    "name-twice": lambda doubt: f"two obstacles are called {doubt.about[0]!r}",
    "name-of-a-part": lambda doubt: (
        f"obstacle {doubt.about[0]!r} has the name of a part of the robot"
    ),
    "unknown-name": lambda doubt: (
        f"nothing is called {doubt.about[0]!r}; there are {', '.join(doubt.because)}"
    ),
    "unusable-shape": lambda doubt: f"the shape of obstacle {doubt.about[0]!r} cannot be used",
    "odd-size": _odd_size,
    "hardly-watched": lambda doubt: (
        f"{doubt.numbers['pairs']:g} of {doubt.numbers['of']:g} pairs of parts of the robot nearly "
        "always touch as they are modelled, so hardly anything of it is watched against itself: "
        "give the links their thickness in constraints: {collision: {link_radius_mm: …}}, or the "
        "robot its shapes"
    ),
    "shapes-as-capsules": lambda doubt: (
        "the shapes of the robot are watched as convex solids of few faces around them; "
        "constraints: {collision: {}} watches the shapes themselves"
    ),
    "chain-as-capsules": _chain_as_capsules,
    "not-watched": lambda doubt: f"{_NOT_WATCHED[doubt.because[0]]}: {', '.join(doubt.about)}",
}
