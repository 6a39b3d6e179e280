"""What a campaign is: test poses, experiments, cell, criteria."""
