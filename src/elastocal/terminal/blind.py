"""What a plan cannot see, as a table."""

from __future__ import annotations

from rich import box
from rich.table import Table
from rich.text import Text

from elastocal.planning.blind import BlindEffect, BlindErrors
from elastocal.terminal.console import micrometres, out, whole
from elastocal.wording.blind import BLIND, effect_name, proof_sentence, seen_phrase, size_of

_WORST = 5  # rows of each kind


def show_blind(found: BlindErrors | None, plan: str = "") -> None:
    """What is invisible, then the worst of what is visible; nothing if None.

    Args:
        found: What the plan cannot see.
        plan: Its name, if there are several.
    """
    if found is None:
        return
    title = BLIND + (f" in {plan}" if plan else "")
    table = Table(title=Text(title), title_justify="left", box=box.SIMPLE_HEAD)
    for column in (_FIRST, "of this size", "is seen", "leaves"):
        table.add_column(column, justify="left" if column in ("is seen", _FIRST) else "right")
    for effect in (*found.invisible[:_WORST], *found.visible[:_WORST]):
        table.add_row(*_row(effect))
    if table.rows:
        whole(table)
    if left := len(found.effects) - len(table.rows):
        out.print(Text(f"{left} more leave less; `--json` has all."))
    if said := proof_sentence(found):
        out.print(Text(said))


_FIRST = "what may be there"


def _row(effect: BlindEffect) -> tuple[Text | str, ...]:
    style = "yellow" if effect.invisible else ""
    return (
        Text(effect_name(effect), style),
        Text(size_of(effect.size, effect.unit)),
        Text(seen_phrase(effect, invisible=effect.invisible)),
        micrometres(effect.error),
    )
