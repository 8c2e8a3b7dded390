"""What a study's ranking owes to each step of its simulation."""
