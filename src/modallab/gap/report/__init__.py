"""What a diagnosis reports: size, place, shrinkage, contradictions, next step."""
