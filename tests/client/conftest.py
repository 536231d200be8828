"""The service in this process."""

from lab_fixtures import lab, labs, lease_given_back, link_rig

__all__ = ["lab", "labs", "lease_given_back", "link_rig"]
