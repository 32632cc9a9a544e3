"""What the larger studies compute: cases, jobs and their results; what is said of them stands in `study`."""
