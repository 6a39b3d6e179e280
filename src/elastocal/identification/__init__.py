"""From readings to compliances with their doubt; knows no study."""
