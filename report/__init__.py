"""What a person sees after a session: overlay pictures, contact sheets and `report.html`."""
