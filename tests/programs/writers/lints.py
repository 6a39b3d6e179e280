"""Format rules of the controllers, as lints: each returns complaints about exported files."""

from __future__ import annotations

import re

import yaml

from tests.programs.writers.parsers import QUICK_YAML

Files = dict[str, str]


def _words(text: str) -> set[str]:
    return set(text.split())


# From the language references, written down apart from the writers.
KRL_WORDS = _words(
    """
    AND BOOL BRAKE CASE CHAR CIRC CONFIRM CONTINUE DECL DEF DEFAULT DEFDAT DEFFCT DO ELSE END
    ENDDAT ENDFCT ENDFOR ENDIF ENDLOOP ENDSWITCH ENDWHILE ENUM EXIT EXT EXTFCT FALSE FOR
    GLOBAL GOTO HALT IF IMPORT INT INTERRUPT LIN LOOP NOT OR PTP PUBLIC REAL REPEAT RETURN
    SIGNAL STRUC SWITCH THEN TO TRIGGER TRUE UNTIL WAIT WHILE
    """
)
RAPID_WORDS = _words(
    """
    ALIAS AND BACKWARD CASE CONNECT CONST DEFAULT DIV DO ELSE ELSEIF ENDFOR ENDFUNC ENDIF
    ENDMODULE ENDPROC ENDRECORD ENDTEST ENDTRAP ENDWHILE ERROR EXIT FALSE FOR FROM FUNC GOTO
    IF INOUT LOCAL MOD MODULE NOSTEPIN NOT NOVIEW OR PERS PROC RAISE READONLY RECORD RETRY
    RETURN STEP SYSMODULE TEST THEN TO TRAP TRUE TRYNEXT UNDO VAR VIEWONLY WHILE WITH XOR
    """
)
UR_WORDS = _words(
    """
    and break continue def elif else end False for global halt if in local loop not or pass
    return run sec thread True while xor
    """
)
DEVICES = {"CON", "PRN", "AUX", "NUL"} | {f"{d}{i}" for d in ("COM", "LPT") for i in range(1, 10)}


def _text(files: Files, longest: int) -> list[str]:
    found = []
    for name, text in files.items():
        for number, line in enumerate(text.splitlines(), 1):
            if not re.fullmatch(r"[\t -~]*", line):
                found.append(f"{name}:{number}: not ASCII")
            if len(line) > longest:
                found.append(f"{name}:{number}: {len(line)} characters")
            if line != line.rstrip() and not name.endswith(".ls"):
                found.append(f"{name}:{number}: space at the end")
        if not text.endswith("\n"):
            found.append(f"{name}: no newline at the end")
        if "-0.0000," in text or re.search(r"-0\.0+[,\] ]", text):
            found.append(f"{name}: minus zero")
        unnamed = re.sub(re.escape(name.split(".")[0]), "", text, flags=re.IGNORECASE)
        if re.search(r"\bnan\b|\binf\b", unnamed, re.IGNORECASE):
            found.append(f"{name}: not a number")
        if "sha256" not in text.replace("\n", " ") or "SAFETY" not in text:
            found.append(f"{name}: no provenance or no safety line")
    return found


def _names(names: list[str], longest: int, words: set[str]) -> list[str]:
    found = [f"name {n!r} is repeated" for n in {n for n in names if names.count(n) > 1}]
    for name in names:
        if not re.fullmatch(r"[A-Za-z]\w*", name, re.ASCII):
            found.append(f"name {name!r} is not an identifier")
        if len(name) > longest:
            found.append(f"name {name!r} has {len(name)} characters")
        if name.upper() in {w.upper() for w in words}:
            found.append(f"name {name!r} is reserved")
    return found


def lint_krl(files: Files) -> list[str]:
    found = _text(files, 255)
    (data,) = (name for name in files if name.endswith(".dat"))
    dat = files[data]
    if dat.count("\nDEFDAT ") != 1 or not dat.endswith("\nENDDAT\n"):
        found.append("DEFDAT and ENDDAT are not balanced")
    points = re.findall(r"^DECL E6AXIS (\w+)=", dat, re.M)
    found += _names(points, 24, KRL_WORDS)
    if re.findall(r"^DEFDAT (\w+)", dat, re.M) != [data.removesuffix(".dat")]:
        found.append("file and module names differ")
    for name, text in files.items():
        if name.endswith(".src"):
            found += _lint_src(name.removesuffix(".src"), text, points)
    if data.replace(".dat", ".src") not in files:
        found.append("there is no .src beside the .dat")
    together = "".join(files.values())
    for cells in re.findall(r"(?:^DECL E6AXIS \w+=|^PTP )\{(.*)\}$", together, re.M):
        labels = [cell.split(" ")[0] for cell in cells.split(",")]
        if not set(labels) <= {f"{a}{i}" for a in "AE" for i in range(1, 7)}:
            found.append(f"axes {labels}")
    return found


def _lint_src(module: str, src: str, points: list[str]) -> list[str]:
    found = []
    code = [line.split(";")[0].strip() for line in src.splitlines()]
    opened = 0
    for line in code:
        opened += bool(re.match(r"DEF\b", line)) - (line == "END")
        if opened not in (0, 1):
            found.append("DEF and END are not balanced")
    if opened:
        found.append("DEF and END are not balanced")
    if src.count(";FOLD") != src.count(";ENDFOLD"):
        found.append("FOLD and ENDFOLD are not balanced")
    names = re.findall(r"^DEF (\w+)", src, re.M)
    if names[:1] != [module]:
        found.append("file and module names differ")
    found += _names(names, 24, KRL_WORDS)
    for line in code:
        target = re.fullmatch(r"PTP (\w\S*)", line)
        if target and target[1] not in points:
            found.append(f"point {target[1]!r} is not declared")
        if re.match(r"(DEF|EXT)\b.*:OUT", line):
            found.append(f"what is called with a literal takes it as a variable: {line}")
    for said in re.findall(r'"([^"\n]*)"', src):
        if len(said) > 80:
            found.append("message of more than 80 characters")
    return found


def lint_rapid(files: Files) -> list[str]:
    found = _text(files, 255)
    for text in files.values():
        found += _lint_module(text)
    return found


def _lint_module(text: str) -> list[str]:
    found = []
    code = [line.strip() for line in text.splitlines() if not line.strip().startswith("!")]
    code = [line for line in code if line]
    module = re.fullmatch(r"MODULE (\w+)", code[0])
    if not module or code[-1] != "ENDMODULE":
        found.append("MODULE and ENDMODULE are not balanced")
    procs = re.findall(r"^\s*PROC (\w+)\(\)$", text, re.M)
    if len(procs) != code.count("ENDPROC") or len(procs) != 1:
        found.append("PROC and ENDPROC are not balanced")
    points = re.findall(r"LOCAL CONST jointtarget (\w+):=", text)
    variables = re.findall(r"LOCAL VAR num (\w+):=", text)
    found += _names(
        [*(module.groups() if module else ()), *procs, *points, *variables], 32, RAPID_WORDS
    )
    for line in code:
        structure = re.match(r"(MODULE|ENDMODULE|PROC|ENDPROC)\b", line)
        if not structure and not line.endswith(";"):
            found.append(f"no semicolon: {line}")
        if re.match(r"(CONST|VAR|PERS)\b", line):
            found.append(f"data that another module can have too: {line}")
        target = re.match(r"MoveAbsJ (\w+)", line)
        if target and target[1] not in points:
            found.append(f"target {target[1]!r} is not declared")
    for row in re.findall(r"(?::=|MoveAbsJ )(\[\[.*\]\])", text):
        groups = re.findall(r"\[([^\[\]]+)\]", row)
        if [len(group.split(",")) for group in groups] != [6, 6]:
            found.append(f"jointtarget {row}")
    found += [
        "string of more than 80 characters" for s in re.findall(r'"([^"\n]*)"', text) if len(s) > 80
    ]
    return found


def lint_fanuc(files: Files) -> list[str]:
    found = _text(files, 250)
    for file, text in files.items():
        found += _lint_program(file, text)
    return found


def _lint_program(file: str, text: str) -> list[str]:
    found = []
    sections = re.findall(r"^/(PROG|ATTR|MN|POS|END)\b", text, re.M)
    if sections != ["PROG", "ATTR", "MN", "POS", "END"]:
        return [*found, f"sections are {sections}"]
    name = re.search(r"^/PROG\s+(\S+)", text)[1]  # type: ignore[index]
    if file != f"{name}.ls" or name != name.upper():
        found.append("file and program names differ, or not upper case")
    found += _names([name], 16, DEVICES)
    date = r"DATE \d\d-\d\d-\d\d  TIME \d\d:\d\d:\d\d;"
    for attribute in ("CREATE", "MODIFIED"):
        if not re.search(rf"^{attribute}\s*= {date}$", text, re.M):
            found.append(f"no {attribute}")
    body = text.split("/MN\n")[1].split("/POS\n")[0].splitlines()
    for number, line in enumerate(body, 1):
        found_line = re.fullmatch(r"\s*(\d+):(.*) ?;", line)
        if not found_line or int(found_line[1]) != number:
            found.append(f"line {number}: {line}")
            continue
        if ";" in found_line[2]:
            found.append(f"line {number}: an instruction ends in it")
        statement = found_line[2].strip()
        if statement.startswith("!") and len(statement) > 33:
            found.append(f"line {number}: remark of {len(statement) - 1} characters")
        message = re.fullmatch(r"MESSAGE\[(.*)\]", statement)
        if message and len(message[1]) > 24:
            found.append(f"line {number}: message of {len(message[1])} characters")
        percent = re.match(r"J P\[\d+\] (\d+)%", statement)
        if percent and not 1 <= int(percent[1]) <= 100:
            found.append(f"line {number}: speed")
    count = int(re.search(r"LINE_COUNT\s*= (\d+);", text)[1])  # type: ignore[index]
    if count != len(body):
        found.append(f"LINE_COUNT {count}, found {len(body)} lines")
    comment = re.search(r'COMMENT\s*= "(.*)";', text)[1]  # type: ignore[index]
    if len(comment) > 16:
        found.append("comment of more than 16 characters")
    positions = text.split("/POS\n")[1]
    numbers = [int(n) for n in re.findall(r"^P\[(\d+)\]\{", positions, re.M)]
    if numbers != list(range(1, len(numbers) + 1)) or positions.count("};") != len(numbers):
        found.append(f"positions are numbered {numbers}")
    used = {int(n) for n in re.findall(r":J P\[(\d+)\]", text)}
    if not used <= set(numbers):
        found.append(f"positions {sorted(used - set(numbers))} are missing")
    for block in re.findall(r"P\[\d+\]\{\n(.*?)\};", positions, re.S):
        cells = re.findall(r"([JE]\d)=(.{10}) (deg| mm)(,?)", block)
        if [c[3] for c in cells] != [","] * (len(cells) - 1) + [""]:
            found.append("commas between joints")
        if not cells or any(len(c[1]) != 10 for c in cells) or block.count("=") != len(cells):
            found.append(f"joint fields: {block}")
    return found


def lint_urscript(files: Files) -> list[str]:
    """What the maker asks of a script that is sent to the robot, and of one for a Script node."""
    found = _text(files, 320)
    for file, text in files.items():
        name = file.removesuffix(".script")
        lines = text.splitlines()
        if lines[-1] == f"{name}()":
            lines.pop()
        if lines[0] != f"def {name}():" or lines[-1] != "end":
            found.append("def and end are not balanced")
        found += _names([name], 32, UR_WORDS)
        for line in lines[1:-1]:
            if not line.startswith("  ") or line.strip() == "end":
                found.append(f"line: {line}")
            code = re.sub(r'"[^"]*"|#.*', "", line)
            if code.count("(") != code.count(")"):
                found.append(f"line: {line}")
            joints = re.search(r"movej\(\[(.*?)\]", line)
            values = [abs(float(v)) for v in joints[1].split(",")] if joints else []
            if joints and (len(values) != 6 or max(values) > 6.4):
                found.append(f"movej needs six angles in radians: {line}")
    return found


def lint_ros(files: Files) -> list[str]:
    found = _text(files, 400)
    (text,) = files.values()
    documents = [d for d in yaml.load_all(text, QUICK_YAML) if d is not None]
    names = {tuple(d["joint_names"]) for d in documents}
    if len(names) != 1:
        found.append("joint names change")
    for document in documents:
        times = [
            p["time_from_start"]["sec"] * 10**9 + p["time_from_start"]["nanosec"]
            for p in document["points"]
        ]
        if times != sorted(set(times)) or times[0] <= 0:
            found.append("times do not increase")
    return found


def lint_csv(files: Files) -> list[str]:
    found = _text(files, 600)
    (text,) = files.values()
    rows = [line for line in text.splitlines() if not line.startswith("#")]
    if len({row.count(",") for row in rows}) != 1:
        found.append("rows differ in length")
    if any(c in text for c in '"|'):
        found.append("quotes or bars")
    return found


LINTS = {
    "krl": lint_krl,
    "rapid": lint_rapid,
    "fanuc": lint_fanuc,
    "urscript": lint_urscript,
    "ros": lint_ros,
    "csv": lint_csv,
}
