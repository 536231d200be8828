"""Keeps what the device delivered: append-only, never rewritten, safe under kill -9."""
