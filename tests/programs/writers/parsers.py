"""Small parsers of the exported languages, written from the formats, not from the writers.

Each returns what the controller would do, as a list of events in order of execution:
("move", values), ("wait", seconds), ("stop", text read so far), ("pulse", output).
"""

from __future__ import annotations

import csv
import io
import json
import re
from typing import Any

import yaml

QUICK_YAML = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
"""The safe loader in C where there is one: long paths are long documents."""
Event = tuple[str, Any]
Files = dict[str, str]


def one(files: Files, ending: str) -> str:
    """The text of the only file with an ending."""
    (text,) = [text for name, text in files.items() if name.endswith(ending)]
    return text


def _known(line: str, patterns: tuple[str, ...]) -> None:
    """Refuse a line that no pattern says: what a controller would do with it, nobody planned."""
    assert any(re.fullmatch(pattern, line) for pattern in patterns), f"unknown line: {line!r}"


_KRL_QUIET = (
    r"", r";.*", r"&ACCESS RVP", r"&REL 1", r"BAS \(#(INITMOV|VEL_PTP|ACC_PTP|TOOL|BASE),\d+\)",
    r"GLOBAL INTERRUPT DECL 3 WHEN \$STOPMESS==TRUE DO IR_STOPM \( \)", r"INTERRUPT ON 3",
)  # fmt: skip


def parse_krl(files: Files) -> list[Event]:
    """The module with a .dat is the one to start; what it calls are the other files."""
    data = one(files, ".dat")
    points: dict[str, list[float]] = {}
    labels: list[list[str]] = []

    def values(aggregate: str) -> list[float]:
        cells = [cell.split(" ") for cell in aggregate.split(",")]
        labels.append([label for label, _ in cells])
        assert labels[-1] == labels[0]
        return [float(value) for _, value in cells]

    for line in data.splitlines():
        found = re.fullmatch(r"DECL E6AXIS (\w+)=\{(.*)\}", line)
        if found:
            points[found[1]] = values(found[2])
        else:
            _known(line, (*_KRL_QUIET, r"DEFDAT \w+", r"ENDDAT", r"EXT BAS \(.*\)"))
    events: list[Event] = []
    said: list[str] = []

    def run(name: str) -> None:
        main, _, rest = files[f"{name}.src"].partition("\nEND\n")
        assert rest == "" or rest.startswith("\nDEF EC_SAY (TEXT[] :IN)\n")
        for line in (raw.split(" ;")[0].strip() for raw in main.splitlines()):
            if found := re.fullmatch(r"PTP (\w+)", line):
                events.append(("move", points[found[1]]))
            elif found := re.fullmatch(r"PTP \{([^{}]*)\}", line):
                events.append(("move", values(found[1])))
            elif found := re.fullmatch(r"WAIT SEC (\d+\.\d\d)", line):
                events.append(("wait", float(found[1])))
            elif found := re.fullmatch(r'EC_SAY \("([^"]*)"\)', line):
                said.append(found[1])
            elif found := re.fullmatch(r"PULSE \(\$OUT\[(\d+)\],TRUE,0.5\)", line):
                events.append(("pulse", found[1]))
            elif found := re.fullmatch(r"(\w+) \( \)", line):
                run(found[1])
            elif line == "HALT":
                events.append(("stop", " ".join(said)))
                said.clear()
            else:
                _known(line, (*_KRL_QUIET, rf"DEF {name} \( \)"))

    run(next(name for name in files if name.endswith(".dat"))[:-4])
    return events


def parse_rapid(files: Files) -> list[Event]:
    """The module that no other calls is the one to start."""
    called = set(re.findall(r"^    Run_(\w+);$", "\n".join(files.values()), re.M))
    (main,) = {name.removesuffix(".mod") for name in files} - called
    events: list[Event] = []
    said: list[str] = []

    def values(target: str) -> list[float]:
        arm, outside = re.fullmatch(r"\[\[([^\]]*)\],\[([^\]]*)\]\]", target).groups()  # type: ignore[union-attr]
        used = [float(v) for v in outside.split(",") if float(v) != 9e9]
        return [float(v) for v in arm.split(",")] + used

    def run(name: str) -> None:
        points = {}
        for line in (raw.strip() for raw in files[f"{name}.mod"].splitlines()):
            if found := re.fullmatch(r"LOCAL CONST jointtarget (\w+):=(.*);", line):
                points[found[1]] = values(found[2])
            elif found := re.fullmatch(r"MoveAbsJ (\S*)\\NoEOffs,v1000,fine,tool0;", line):
                place = found[1]
                events.append(("move", points[place] if place in points else values(place)))
            elif found := re.fullmatch(r"WaitTime \\InPos,(\d+\.\d\d);", line):
                events.append(("wait", float(found[1])))
            elif line == "TPErase;":
                said.clear()
            elif found := re.fullmatch(r'TPWrite "([^"\\]*)";', line):
                said.append(found[1])
            elif found := re.fullmatch(r"PulseDO \\PLength:=0.5,(\w+);", line):
                events.append(("pulse", found[1]))
            elif re.fullmatch(r'TPReadFK nAnswer,"Done\? Then go on.",(stEmpty,){4}"Go on";', line):
                events.append(("stop", " ".join(said)))
            elif found := re.fullmatch(r"Run_(\w+);", line):
                run(found[1])
            else:
                quiet = (
                    r"", r"!.*", rf"MODULE {name}", rf"PROC Run_{name}\(\)", r"ENDPROC",
                    r"ENDMODULE", r"VelSet \d+,\d+;", r"LOCAL VAR num nAnswer:=0;",
                )  # fmt: skip
                _known(line, quiet)

    run(main)
    return events


def parse_fanuc(files: Files) -> list[Event]:
    """The program that no other calls is the one to start; an instruction ends at a semicolon."""
    called = set(re.findall(r"CALL (\w+)", "\n".join(files.values())))
    (main,) = {name.removesuffix(".ls") for name in files} - called
    events: list[Event] = []
    said: list[str] = []

    def run(name: str) -> None:
        _, rest = files[f"{name}.ls"].split("/MN\n")
        body, positions = rest.split("/POS\n")
        points = {}
        for number, block in re.findall(r"P\[(\d+)\]\{(.*?)\};", positions, re.DOTALL):
            cells = re.findall(r"([JE]\d)=\s*(-?[\d.]+)\s+(deg|mm)", block)
            points[int(number)] = [float(value) for _, value, _ in cells]
        for number, line in enumerate(body.splitlines(), 1):
            at, _, instructions = line.partition(":")
            assert int(at) == number
            statement, *more = [part.strip() for part in instructions.split(";")]
            assert more == [""], f"several instructions: {line!r}"
            if found := re.fullmatch(r"J P\[(\d+)\] \d+% FINE", statement):
                events.append(("move", points[int(found[1])]))
            elif found := re.fullmatch(r"WAIT +([\d.]+)\(sec\)", statement):
                events.append(("wait", float(found[1])))
            elif found := re.fullmatch(r"MESSAGE\[([^\[\]]*)\]", statement):
                said.append(found[1])
            elif found := re.fullmatch(r"DO\[(\d+)\]=PULSE,0.5sec", statement):
                events.append(("pulse", found[1]))
            elif found := re.fullmatch(r"CALL (\w+)", statement):
                run(found[1])
            elif statement == "PAUSE":
                events.append(("stop", " ".join(said)))
                said.clear()
            else:
                _known(statement, (r"!.*", r"UFRAME_NUM=0", r"UTOOL_NUM=1"))

    run(main)
    return events


def parse_urscript(files: Files) -> list[Event]:
    """Scripts one after the other, in the order of their names."""
    events: list[Event] = []
    for name in sorted(files):
        first, *lines = files[name].splitlines()
        assert first == f"def {name.removesuffix('.script')}():"
        if lines[-1] == f"{first[4:-1]}":
            lines.pop()  # a Script node: the call of the function
        assert lines[-1] == "end"
        assert all(line.startswith("  ") for line in lines[:-1])
        for line in (raw.split("  # ")[0].strip() for raw in lines[:-1]):
            if found := re.fullmatch(r"movej\((\[[^\]]*\]), a=[\d.]+, v=[\d.]+\)", line):
                events.append(("move", json.loads(found[1])))
            elif line == "sleep(0.5)" and events and events[-1][0] == "pulse":
                continue
            elif found := re.fullmatch(r"sleep\((\d+\.\d\d)\)", line):
                events.append(("wait", float(found[1])))
            elif found := re.fullmatch(r"set_standard_digital_out\((\d), True\)", line):
                events.append(("pulse", found[1]))
            elif found := re.fullmatch(
                r'popup\("([^"]*)", title="elastocal", blocking=True\)', line
            ):
                events.append(("stop", found[1]))
            else:
                _known(line, (r"", r"#.*", r"set_standard_digital_out\(\d, False\)"))
    return events


def parse_ros(files: Files) -> list[Event]:
    """Here a stop is the comments after a document; settling with the load on is among them."""
    text = one(files, ".yaml")
    documents = text.split("\n---\n")[1:]
    for line in text.splitlines():
        key = r"(header|joint_names|points|  velocities|  time_from_start): ?.*"
        _known(line, (r"---", r"# .*", key, r"- positions: \[.*\]  # \w+"))
    assert len(list(yaml.load_all(text, QUICK_YAML))) == len(documents)
    events: list[Event] = []
    for document in documents:
        message = yaml.load(document, QUICK_YAML)
        assert set(message) == {"header", "joint_names", "points"}
        clock = 0.0
        settles = ["# settle" in li for li in document.splitlines() if li.startswith("- p")]
        for point, settle in zip(message["points"], settles, strict=True):
            stamp = point["time_from_start"]
            assert 0 <= stamp["nanosec"] < 10**9
            assert isinstance(stamp["sec"], int)
            time = stamp["sec"] + 1e-9 * stamp["nanosec"]
            assert time > clock
            assert len(point["positions"]) == len(message["joint_names"])
            assert set(point["velocities"]) == {0.0}
            if settle:
                assert point["positions"] == events[-1][1]
                events.append(("wait", time - clock))
            else:
                events.append(("move", point["positions"]))
            clock = time
        comments = [line[2:] for line in document.splitlines() if line.startswith("# ")]
        if comments:
            events.append(("stop", " ".join(comments)))
    return events


def parse_csv(files: Files) -> list[Event]:
    text = one(files, ".csv")
    assert text.splitlines() == text.split("\n")[:-1]
    rows = [line for line in text.splitlines() if not line.startswith("#")]
    table = list(csv.DictReader(io.StringIO("\n".join(rows)), quotechar="|"))
    joints = [c for c in table[0] if c.endswith((" [deg]", " [mm]"))]
    events: list[Event] = []
    for number, row in enumerate(table, 1):
        assert row["step"] == str(number)
        if row["do"] == "move":
            events.append(("move", [float(row[joint]) for joint in joints]))
        elif row["do"] == "wait":
            events.append(("wait", float(row["seconds"])))
        else:
            assert row["do"] in ("ask", "measure")
            events.append(("stop", row["text"].replace(";", ",")))
    return events


PARSERS = {
    "krl": parse_krl,
    "rapid": parse_rapid,
    "fanuc": parse_fanuc,
    "urscript": parse_urscript,
    "ros": parse_ros,
    "csv": parse_csv,
}
