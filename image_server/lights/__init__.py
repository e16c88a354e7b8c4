"""Lights on a serial line: levels to channels, two protocols, and darkness however the server ends."""
