"""Files: study, plan. The boundary where units are converted and everything is checked."""
