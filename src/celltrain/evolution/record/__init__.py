"""What is kept of a simulation: steps, frames, its file, and what is computed from them again."""
