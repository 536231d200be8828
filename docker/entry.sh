#!/bin/sh
# Names the database to the data folder, without its password, and begins the command.
set -eu

if [ -n "${DATABASE_URL:-}" ]; then
    umask 077
    printf '%s\n' "$DATABASE_URL" > "${MODALLAB_DATA:-/data}/database.url"
fi
if [ -r "${DATABASE_PASSWORD_FILE:-}" ]; then
    PGPASSWORD=$(cat "$DATABASE_PASSWORD_FILE")
    export PGPASSWORD
fi
exec "$@"
