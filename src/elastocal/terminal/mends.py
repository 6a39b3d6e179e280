"""What would make a plan promise more, as a table."""

from __future__ import annotations

from collections.abc import Sequence

from rich import box
from rich.table import Table
from rich.text import Text

from elastocal.planning.mends import Mend
from elastocal.terminal.console import micrometres, out, whole
from elastocal.wording.mends import ESTIMATES, MENDS, mend_name, minutes_phrase


def show_mends(found: Sequence[Mend]) -> None:
    """The ways, the best first; nothing if there are none."""
    if not found:
        return
    table = Table(title=MENDS, title_justify="left", box=box.SIMPLE_HEAD)
    for column in ("what is done", "promises", "at the cell"):
        table.add_column(column, justify="left" if column == "what is done" else "right")
    for mend in found:
        table.add_row(Text(mend_name(mend)), micrometres(mend.promised), minutes_phrase(mend))
    whole(table)
    out.print(Text(ESTIMATES))
