"""No byte that was not recorded is served as if it had been."""

from pathlib import Path

import h5py
import numpy as np
import pytest
from recorded_run import record_run

from modallab.core.errors import BlockDamagedError
from modallab.service.api.problems import response_of_error
from modallab.service.campaigns.runs import block_record, read_samples
from modallab.service.context import open_service
from modallab.service.records.leases import RigLeases
from modallab.service.rigs.controllers import RigControllers
from modallab.storage import Store
from modallab.storage.samples import DATASET


def test_a_damaged_block_is_a_problem_that_names_it_and_the_others_are_served(tmp_path: Path) -> None:
    with Store(tmp_path) as store:
        run = record_run(store, blocks=3)
        service = open_service(tmp_path, RigControllers([], RigLeases(store.catalogue.engine, "start")), "start")
        whole = read_samples(service, block_record(service, run, 1))
        with h5py.File(store.samples_file(run), "r+") as file:
            file[DATASET][0, 64 + 5] += 1
        with pytest.raises(BlockDamagedError, match="differ from the recording") as damaged:
            read_samples(service, block_record(service, run, 1))
        assert f"run {run}, block 1" in damaged.value.where
        answer = response_of_error(damaged.value)
        assert (answer.status_code, b'"code":"block-damaged"' in answer.body) == (500, True)
        assert not np.array_equal(read_samples(service, block_record(service, run, 2)), whole)
        service.close()
