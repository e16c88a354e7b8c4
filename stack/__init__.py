"""Recorded light stacks: their files, the law of exposure, and the sensor."""
