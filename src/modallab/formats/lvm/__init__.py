"""LabVIEW measurement files."""
