"""The part of the client that archives, deletes and restores."""

from modallab.client.connection import Connection
from modallab.core.documents.campaigns import CampaignView
from modallab.core.documents.runs import RunView


def query_for_hidden(*, archived: bool, deleted: bool) -> dict[str, str]:
    """The query that lists what is hidden otherwise."""
    return {name: "true" for name, wanted in (("archived", archived), ("deleted", deleted)) if wanted}


class ArchiveCalls(Connection):
    """Campaigns and runs that are not wanted in lists, or not at all; what is deleted can be restored for a while."""

    def archive_campaign(self, campaign: str) -> CampaignView:
        """Leave a campaign out of lists."""
        return self._post(CampaignView, f"/campaigns/{campaign}/archive")

    def delete_campaign(self, campaign: str) -> CampaignView:
        """Delete a campaign with its runs; `purge_utc` says until when it can be restored."""
        return CampaignView.model_validate_json(self._send("DELETE", f"/campaigns/{campaign}").content)

    def restore_campaign(self, campaign: str) -> CampaignView:
        """Have a campaign back that is archived or deleted."""
        return self._post(CampaignView, f"/campaigns/{campaign}/restore")

    def archive_run(self, run: str) -> RunView:
        """Leave a run out of lists, and out of what is made of its campaign unless it is named."""
        return self._post(RunView, f"/runs/{run}/archive")

    def delete_run(self, run: str) -> RunView:
        """Delete a run that has ended; `purge_utc` says until when it can be restored."""
        return RunView.model_validate_json(self._send("DELETE", f"/runs/{run}").content)

    def restore_run(self, run: str) -> RunView:
        """Have a run back that is archived or deleted."""
        return self._post(RunView, f"/runs/{run}/restore")
