"""From a study to a plan with its certificate, and what a plan is worth."""
