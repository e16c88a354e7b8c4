"""Pure geometry that both servers know: poses, cameras, models and what of a model can be seen."""
