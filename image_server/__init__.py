"""The image server: settings in, frame out. One file per device."""
