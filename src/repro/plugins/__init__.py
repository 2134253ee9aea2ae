"""What is chosen by name: one module per choice, found by listing a folder, and the typed options it declares."""
