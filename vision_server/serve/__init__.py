"""The vision server: sessions behind the wire protocol."""
