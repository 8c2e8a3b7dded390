"""The reference pages, and the JSON Schema of recipes, that follow from the code."""
