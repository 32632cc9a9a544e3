"""What the larger studies compute: cases, jobs and their results; their reports are in `study`."""
