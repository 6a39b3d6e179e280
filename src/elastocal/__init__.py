"""elastocal: calibration experiments for the compliance of robot arms, planned with a proof."""

__version__ = "0.1.0"
