"""From a numerical bound to a proved one: its statement in plain numbers, and what proves it."""
