"""From a fit to the modal model."""
