"""Reading and writing the service's tables: each write is committed and on the disk when its block is left."""

from collections.abc import Generator
from contextlib import contextmanager

from sqlalchemy import Connection, Engine
from sqlalchemy.exc import SQLAlchemyError

from modallab.core.errors import StorageError
from modallab.storage.durable import failure


@contextmanager
def writing(engine: Engine) -> Generator[Connection]:
    """A transaction that writes.

    Raises:
        DiskFullError, StorageError: nothing of it was kept.
    """
    try:
        with engine.begin() as connection:
            yield connection
    except SQLAlchemyError as error:
        raise failure(error, _name(engine)) from error


@contextmanager
def reading(engine: Engine) -> Generator[Connection]:
    """A transaction that only reads.

    Raises:
        StorageError: the database cannot be read.
    """
    try:
        with engine.connect().execution_options(reading=True) as connection:
            yield connection
    except SQLAlchemyError as error:
        raise StorageError(f"cannot be read: {error}", where=_name(engine), remedy="look at the disk") from error


def _name(engine: Engine) -> str:
    return engine.url.render_as_string(hide_password=True)
