"""A device behind the wire protocol."""
