"""Sections: one file per stage of a campaign; each turns a value into the sections it fills."""
