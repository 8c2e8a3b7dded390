"""The drawings of the report: one a file, each a pure function from values to an SVG string."""
