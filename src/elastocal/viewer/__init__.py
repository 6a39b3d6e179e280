"""A campaign live in the browser, to step through and to move by hand.

What is shown for a configuration is computed by functions without a web server (`subject`,
`readout`, `parts`, `surroundings`); `local_server`, `scene` and `panel` hand it to viser.
"""
