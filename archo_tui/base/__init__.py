"""What every room uses: clock, errors, files, threads and texts."""
