"""What a user writes, and the Case that it stands for."""
