"""Measurement files, step by step: text, layout, columns, cells, readings, remarks."""
