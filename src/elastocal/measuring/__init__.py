"""What is read, and how well: instruments and measurements."""
