"""The optimal-design core, on problems without a robot."""
