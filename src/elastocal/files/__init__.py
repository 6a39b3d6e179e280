"""Files in and out, one sub-room per kind: units are converted and everything is checked."""
