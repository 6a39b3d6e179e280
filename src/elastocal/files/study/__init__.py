"""Study files, section by section."""
