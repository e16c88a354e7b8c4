"""Recording a stack from a device."""
