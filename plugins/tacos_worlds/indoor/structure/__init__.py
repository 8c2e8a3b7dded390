"""What a building has before furniture: walls, floors, doors, windows, skirting, ceiling lights."""
