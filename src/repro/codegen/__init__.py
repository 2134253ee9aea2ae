"""From CasADi expressions to compiled code: straight-line C, vector lanes, and the library that holds it."""
