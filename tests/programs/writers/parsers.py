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

Event = tuple[str, Any]
Files = dict[str, str]


def one(files: Files, ending: str) -> str:
    """The text of the only file with an ending."""
    (text,) = [text for name, text in files.items() if name.endswith(ending)]
    return text


def parse_krl(files: Files) -> list[Event]:
    points: dict[str, list[float]] = {}
    labels = []
    for line in one(files, ".dat").splitlines():
        found = re.match(r"DECL E6AXIS (\w+)=\{(.*)\}$", line)
        if found:
            cells = [cell.split(" ") for cell in found[2].split(",")]
            labels.append([label for label, _ in cells])
            points[found[1]] = [float(value) for _, value in cells]
    assert all(row == labels[0] for row in labels)
    events: list[Event] = []
    said: list[str] = []
    main = one(files, ".src").split("\nEND\n")[0]
    for line in (raw.strip() for raw in main.splitlines()):
        if line.startswith("PTP "):
            events.append(("move", points[line[4:]]))
        elif line.startswith("WAIT SEC "):
            events.append(("wait", float(line[9:])))
        elif line.startswith("EC_SAY"):
            said.append(re.fullmatch(r'EC_SAY \("([^"]*)"\)', line)[1])  # type: ignore[index]
        elif line.startswith("PULSE"):
            events.append(("pulse", re.search(r"\$OUT\[(\d+)\]", line)[1]))  # type: ignore[index]
        elif line == "HALT":
            events.append(("stop", " ".join(said)))
            said = []
    return events


def parse_rapid(files: Files) -> list[Event]:
    text = one(files, ".mod")
    points = {}
    for name, arm, outside in re.findall(
        r"CONST jointtarget (\w+):=\[\[([^\]]*)\],\[([^\]]*)\]\];", text
    ):
        used = [float(v) for v in outside.split(",") if float(v) != 9e9]
        points[name] = [float(v) for v in arm.split(",")] + used
    events: list[Event] = []
    said: list[str] = []
    for line in (raw.strip() for raw in text.splitlines()):
        if line.startswith("MoveAbsJ "):
            name = line[len("MoveAbsJ ") :].split("\\")[0]
            events.append(("move", points[name]))
        elif line.startswith("WaitTime"):
            events.append(("wait", float(line.rstrip(";").split(",")[1])))
        elif line.startswith("TPErase"):
            said = []
        elif line.startswith("TPWrite"):
            said.append(re.fullmatch(r'TPWrite "([^"]*)";', line)[1])  # type: ignore[index]
        elif line.startswith("PulseDO"):
            events.append(("pulse", line.rstrip(";").split(",")[1]))
        elif line.startswith("TPReadFK"):
            events.append(("stop", " ".join(said)))
    return events


def parse_fanuc(files: Files) -> list[Event]:
    text = one(files, ".ls")
    _, rest = text.split("/MN\n")
    body, positions = rest.split("/POS\n")
    points = {}
    for number, block in re.findall(r"P\[(\d+)\]\{(.*?)\};", positions, re.DOTALL):
        cells = re.findall(r"([JE]\d)=\s*(-?[\d.]+)\s+(deg|mm)", block)
        points[int(number)] = [float(value) for _, value, _ in cells]
    events: list[Event] = []
    said: list[str] = []
    for line in body.splitlines():
        statement = line.split(":", 1)[1].rstrip(" ;").strip()
        if statement.startswith("J P["):
            number = int(re.match(r"J P\[(\d+)\]", statement)[1])  # type: ignore[index]
            events.append(("move", points[number]))
        elif statement.startswith("WAIT"):
            events.append(("wait", float(re.search(r"[\d.]+", statement)[0])))  # type: ignore[index]
        elif statement.startswith("MESSAGE["):
            said.append(statement[len("MESSAGE[") : -1])
        elif statement.startswith("DO["):
            events.append(("pulse", re.search(r"\d+", statement)[0]))  # type: ignore[index]
        elif statement == "PAUSE":
            events.append(("stop", " ".join(said)))
            said = []
    return events


def parse_urscript(files: Files) -> list[Event]:
    events: list[Event] = []
    for line in (raw.strip() for raw in one(files, ".script").splitlines()):
        if line.startswith("movej("):
            events.append(("move", json.loads(line[line.index("[") : line.index("]") + 1])))
        elif line == "sleep(0.5)" and events and events[-1][0] == "pulse":
            continue
        elif line.startswith("sleep("):
            events.append(("wait", float(line[6:-1])))
        elif line.startswith("set_standard_digital_out") and "True" in line:
            events.append(("pulse", re.search(r"\d+", line)[0]))  # type: ignore[index]
        elif line.startswith("popup("):
            events.append(("stop", re.match(r'popup\("([^"]*)"', line)[1]))  # type: ignore[index]
    return events


def parse_ros(files: Files) -> list[Event]:
    """Here a stop is the comments after a document; settling with the load on is among them."""
    text = one(files, ".yaml")
    documents = text.split("\n---\n")[1:]
    assert len(list(yaml.safe_load_all(text))) == len(documents)
    events: list[Event] = []
    for document in documents:
        message = yaml.safe_load(document)
        assert set(message) == {"header", "joint_names", "points"}
        clock = 0.0
        settles = ["# settle" in li for li in document.splitlines() if "- positions:" in li]
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
