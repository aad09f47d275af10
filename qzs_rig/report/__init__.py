"""What is shown, as data; a still and an interactive way to draw it; the page around it."""
