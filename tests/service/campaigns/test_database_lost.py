"""A database that cannot be reached is said to be so, in our own words."""

import pytest
from sqlalchemy import text

from modallab.core.errors import DatabaseLostError
from modallab.service.api.problems import response_of_error
from modallab.storage.engine import open_engine, read_transaction, write_transaction


@pytest.mark.parametrize("transaction", [read_transaction, write_transaction])
def test_a_server_that_is_gone_is_503_without_the_drivers_words(transaction) -> None:
    # No server listens at port 1.
    engine = open_engine("postgresql+psycopg://tester@127.0.0.1:1/none")
    with pytest.raises(DatabaseLostError) as lost, transaction(engine) as connection:
        connection.execute(text("SELECT 1"))
    answer = response_of_error(lost.value)
    assert (answer.status_code, answer.headers["retry-after"]) == (503, "1")
    for word in (b"psycopg", b"SELECT", b"sqlalche", b"Connection refused"):
        assert word not in answer.body
    engine.dispose()
