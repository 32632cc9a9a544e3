"""The tables that a file may hold: keys, units, defaults, ranges, and what one table asks of itself."""
