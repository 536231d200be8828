#!/bin/sh
# Makes an authority, and one certificate for all machines of the cluster; anew when it ends soon: certificates.sh FOLDER
set -eu
folder=$1
days_left=30
if [ -s "$folder/cert.pem" ] && openssl x509 -in "$folder/cert.pem" -noout -checkend $((days_left * 86400)); then
    exit 0
fi
umask 077
cd "$folder"
openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 3650 \
    -subj "/CN=modallab authority" -keyout authority.key -out ca.part
openssl req -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes \
    -subj "/CN=modallab cluster" -keyout key.part -out request.pem
openssl x509 -req -in request.pem -CA ca.part -CAkey authority.key -CAcreateserial -days 825 -out cert.part
# Nobody needs the authority's key any more; what was half made is made again.
rm -f authority.key request.pem ca.srl ca.part.srl cert.pem
mv ca.part ca.pem
mv key.part key.pem
mv cert.part cert.pem
