"""From one configuration to the next: margins, ways around, order, hours."""
