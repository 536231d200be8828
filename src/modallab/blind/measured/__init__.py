"""Semi-real trials: known effects put into measured FRFs of any structure, hidden, diagnosed and scored."""
