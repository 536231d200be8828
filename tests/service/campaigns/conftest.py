"""The service in this process."""

from lab_fixtures import lab, link_rig

__all__ = ["lab", "link_rig"]
