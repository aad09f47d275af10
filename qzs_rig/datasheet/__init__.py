"""The platform at rest, told: summary, figures 9 to 12 of the paper, page and CSV."""
