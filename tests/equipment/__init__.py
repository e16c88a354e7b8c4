"""Hardware that is not there: lights on pseudo-terminals, a camera on a virtual USB bus; with faults."""
