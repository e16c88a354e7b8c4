"""Plans of many sessions, estimates and edge maps: run anywhere, continued, compared with intervals."""
