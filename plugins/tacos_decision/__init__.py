"""What a finished study says beyond its winner: all parts ranked, equals, tolerances, importance, fronts."""
