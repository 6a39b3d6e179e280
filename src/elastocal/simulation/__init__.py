"""Campaigns on a virtual robot, one or thousands."""
