"""Light drivers that are not there: emulated on pseudo-terminals, with faults on request."""
