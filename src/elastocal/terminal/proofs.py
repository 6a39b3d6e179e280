"""Records of proofs: what they say, of what."""

from __future__ import annotations

from rich.text import Text

from elastocal.proof.statement import Statement
from elastocal.study.criteria import CRITERIA
from elastocal.terminal.console import out
from elastocal.wording.lists import counted
from elastocal.wording.numbers import number
from elastocal.wording.proofs import MODEL, proved_length


def show_verdict(statement: Statement, name: str, verdict: str) -> None:
    """What a record claims, of which model, what it leaves out, and what became of it.

    Args:
        statement: What it claims.
        name: Name of the file.
        verdict: What the checker says of it.
    """
    s, criterion = statement, CRITERIA.get(statement.criterion)
    claim = "it claims nothing: the proof was ended before it had a bound"
    if s.rho0 is not None:
        is_length = criterion is not None and criterion.is_position_error
        size = proved_length(s.rho0, 6) if is_length else f"{number(s.rho0, 6)} (SI)"
        symbol = s.criterion if criterion is None else criterion.symbol
        claim = f"no plan of {counted(s.count, 'experiment')} has {symbol} below {size}"
    lines = [
        f"Claim: {claim}.",
        f"Of the {MODEL} in the record: study {s.name!r}, sha256 {s.study_sha256}, "
        f"{counted(len(s.joints), 'joint')}, {counted(len(s.unknowns), 'unknown')}.",
    ]
    if s.left_out:
        lines.append(f"Left out, so that the bound may be weaker: {', '.join(s.left_out)}.")
    for line in (*lines, f"{name}: {verdict}"):
        out.print(Text(line))
