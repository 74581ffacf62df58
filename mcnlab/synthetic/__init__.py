"""What is made, with truth: walkers, crossings, a street, a corridor, noise and shifts."""
