"""What everything else uses: formatting of numbers, input files, splines, memory, threads and worker processes."""
