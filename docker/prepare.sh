#!/bin/sh
# Makes the secrets that compose.yaml names, once: a token for the service, a password for the database.
set -eu
umask 077
cd "$(dirname "$0")"
mkdir -p secrets
for name in token database_password; do
    if [ ! -s "secrets/$name" ]; then
        openssl rand -hex 24 > "secrets/$name"
    fi
    # The folder keeps others out; in the container, whose user is another, the file must be readable.
    chmod 0444 "secrets/$name"
done
