"""The corrected twin in the forms that other programs simulate with, each read back and compared with the bench."""
