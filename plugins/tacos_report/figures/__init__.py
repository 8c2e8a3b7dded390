"""The drawings of the report of a study: one a file, each a pure function from values to an SVG string."""
