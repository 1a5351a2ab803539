"""Two places of one coordinate: all motions that join them, proved by enclosures of the time over intervals of E."""
