"""From one configuration to the next: pace, margins, ways around, order, hours."""
