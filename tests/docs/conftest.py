"""The service that blocks of pages ask."""

from lab_fixtures import lab, labs, lease_given_back, link_rig

__all__ = ["lab", "labs", "lease_given_back", "link_rig"]
