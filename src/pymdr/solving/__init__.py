"""Check, map, solve, interpret: the method as one verb, and studies of contacts."""
