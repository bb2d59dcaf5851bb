"""`sunset train`: placeholder."""
