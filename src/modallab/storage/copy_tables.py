"""All rows of one database into another, of whatever kind: the one step of a backup and of a restore."""

from collections.abc import Sequence

from sqlalchemy import Connection, MetaData, Table, func, insert, inspect, select, text

BATCH = 500


def copy_tables(source: Connection, target: Connection, tables: Sequence[MetaData]) -> None:
    """Copy every row of every table that `source` has. `target` must have the tables, empty.

    Args:
        source: in a transaction that sees one moment of the database.
        target: in a transaction.
        tables: the descriptions of the tables.
    """
    known = set(inspect(source).get_table_names())
    for metadata in tables:
        for table in metadata.sorted_tables:
            if table.name in known:
                _copy(source, target, table)


def _copy(source: Connection, target: Connection, table: Table) -> None:
    # What an older program wrote may lack a column; then the new row has its default.
    known = {column["name"] for column in inspect(source).get_columns(table.name)}
    columns = [column for column in table.columns if column.name in known]
    rows = source.execution_options(yield_per=BATCH).execute(select(*columns)).mappings()
    for part in rows.partitions(BATCH):
        target.execute(insert(table), [dict(row) for row in part])
    _go_on_counting(target, table)


def _go_on_counting(target: Connection, table: Table) -> None:
    # PostgreSQL's own counters know nothing of the numbers that came with the rows; SQLite's follow by themselves.
    column = table.autoincrement_column
    if target.dialect.name != "postgresql" or column is None or column.foreign_keys:
        return
    highest = target.scalar(select(func.max(column)))
    sequence = target.scalar(select(func.pg_get_serial_sequence(table.name, column.name)))
    if highest is not None and sequence is not None:
        target.execute(text("SELECT setval(:sequence, :highest)"), {"sequence": sequence, "highest": highest})
