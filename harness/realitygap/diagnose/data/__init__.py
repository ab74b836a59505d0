"""What a diagnosis works on: motions, noise, what is fitted and what is kept back."""
