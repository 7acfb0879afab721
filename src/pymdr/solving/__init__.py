"""Check, map, solve, interpret: the method as one verb, and what is asked around it."""
