"""Tables whose rows are never changed and never leave, by the database's own word."""

from sqlalchemy import DDL, Table, event

_REJECT = """
CREATE OR REPLACE FUNCTION modallab_append_only() RETURNS trigger AS $$
BEGIN RAISE EXCEPTION '%% are append-only', TG_TABLE_NAME USING ERRCODE = 'integrity_constraint_violation'; END
$$ LANGUAGE plpgsql"""


def append_only(*tables: Table) -> None:
    """Have every database that gets these tables reject updates and deletions of their rows."""
    for table in tables:
        for verb in ("UPDATE", "DELETE"):
            _sqlite(table, verb)
        event.listen(table, "after_create", DDL(_REJECT).execute_if(dialect="postgresql"))
        event.listen(table, "after_create", DDL(_trigger(table)).execute_if(dialect="postgresql"))


def _sqlite(table: Table, verb: str) -> None:
    text = (
        f"CREATE TRIGGER {table.name}_no_{verb.lower()} BEFORE {verb} ON {table.name} "
        f"BEGIN SELECT RAISE(ABORT, '{table.name} are append-only'); END"
    )
    event.listen(table, "after_create", DDL(text).execute_if(dialect="sqlite"))


def _trigger(table: Table) -> str:
    return (
        f"CREATE TRIGGER {table.name}_append_only BEFORE UPDATE OR DELETE ON {table.name} "
        "FOR EACH ROW EXECUTE FUNCTION modallab_append_only()"
    )
