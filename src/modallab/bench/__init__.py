"""The bench protocol and its loader by URL."""
