"""What is asked (`case`), what is known (`state`), and what must hold (`contact`, `approach`)."""
