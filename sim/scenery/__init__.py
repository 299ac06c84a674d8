"""How the cell looks in pictures: a second model with the same joints, which no physics and no network reads."""
