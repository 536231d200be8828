"""A small client of the service, for scripts in the lab.

```python
from modallab.client import Client

with Client("http://127.0.0.1:8000", token="...") as lab:
    campaign = lab.create_campaign("first", lab.rigs()[0].id)
    with lab.lease(campaign.rig, "Ada") as lease:
        run = lab.start_run(campaign.id, plan, lease)
        for event in lab.follow(run.id):
            print(event.kind, event.content)
```
"""

from modallab.client.client import Client
from modallab.client.connection import HeldLease, ServiceProblemError

__all__ = ["Client", "HeldLease", "ServiceProblemError"]
