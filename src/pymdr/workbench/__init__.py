"""User interfaces: case files, readers of measured data and the command line."""
