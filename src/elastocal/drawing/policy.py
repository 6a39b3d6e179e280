"""What a page of ours may do in a browser: run its own scripts, and fetch nothing.

Source: Content Security Policy Level 3 (W3C), hashes of inline scripts.
"""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Sequence


def policy(scripts: Sequence[str] = ()) -> str:
    """The Content-Security-Policy of a page whose only scripts are these texts, line ends LF."""
    hashes = [f"'sha256-{_digest(script)}'" for script in scripts]
    return "; ".join(
        [
            "default-src 'none'",
            "script-src " + (" ".join(hashes) or "'none'"),
            "style-src 'unsafe-inline'",  # widths of bars, and what plotly sets
            "img-src data: blob:",
            "base-uri 'none'",
            "form-action 'none'",
        ]
    )


def _digest(script: str) -> str:
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
