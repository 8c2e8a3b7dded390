"""Help for authors of recipes and plugins: the JSON Schema, completion, new projects, the reference pages."""
