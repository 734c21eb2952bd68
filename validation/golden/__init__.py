"""Golden shots: scenes with reference results as JSON, for engines in any language."""
