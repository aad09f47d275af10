"""The platform from first principles: six degrees of freedom, one energy (docs/geometric.md)."""
