"""What a person sees after a session: overlay pictures and `report.html`."""
