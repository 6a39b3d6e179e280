"""The rigid arm: joints, tools, shapes, and where they are in a configuration."""
