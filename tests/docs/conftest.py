"""The service that blocks of pages ask."""

from lab_fixtures import lab, link_rig

__all__ = ["lab", "link_rig"]
