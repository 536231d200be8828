"""Campaign files: one HDF5 file with everything that was recorded."""

CAMPAIGN_FILE = "campaign.h5"
"""Its name where a folder is named in place of it."""
