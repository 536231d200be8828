"""From a campaign to the data the fits see."""
