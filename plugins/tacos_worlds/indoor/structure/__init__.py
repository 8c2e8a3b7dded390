"""Building before furniture: walls, floors, doors, windows, skirting, ceiling lights."""
