"""What a campaign is: test poses, experiments, cell, pace, criteria."""
