"""Colours of the report, told apart by people with any colour vision, and in grey on paper."""

from __future__ import annotations

COLOURS = {
    "ink": "#1b2633",
    "muted": "#54616f",
    "faint": "#8a97a5",
    "line": "#dce2e9",
    "wash": "#f4f6f9",
    "paper": "#ffffff",
    "accent": "#1d5fa8",
    "accent-mid": "#7fa6d1",
    "accent-soft": "#e6eef8",
    "ghost": "#b9c6d6",
    "contrast": "#c8500a",
    "contrast-soft": "#fbeadf",
    "alarm": "#a4161a",
    "alarm-soft": "#fdecec",
}
"""accent: the plan. contrast: the test poses. alarm: what is broken, always with words."""
