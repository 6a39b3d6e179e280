"""Names that controllers accept."""

from __future__ import annotations

from elastocal.programs.writers.names import identifier, plain
from elastocal.programs.writers.wording import wrapped


def test_reserved_words_get_the_first_number_that_is_free() -> None:
    assert identifier("move", 24, ["MOVE"]) == "move_1"
    assert identifier("move", 24, ["Move", "move_1"]) == "move_2"
    assert identifier("abcdefgh", 8, ["ABCDEFGH"]) == "abcdef_1"
    assert identifier("7 axes", 24) == "P_7_axes"


def test_words_with_hyphens_are_not_broken() -> None:
    assert wrapped("apply the load-point force", 16) == ["apply the", "load-point force"]
    assert wrapped("", 16) == [""]


def test_signs_spelt_out_leave_no_space_before_a_stop() -> None:
    assert plain("elevation <= 30° by 60°.") == "elevation <= 30 deg by 60 deg."
    assert plain("10 % (20 %), 5°") == "10 percent (20 percent), 5 deg"
