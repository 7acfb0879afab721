"""Where people meet pymdr: case files and the command line."""
