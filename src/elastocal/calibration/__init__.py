"""From absolute readings to a calibrated robot: base, tool, geometry, compliances, payload."""
