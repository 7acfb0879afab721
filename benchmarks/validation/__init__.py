"""Validation of every physics: ``python -m benchmarks.validation`` recomputes the tables and figures of docs/validation.md."""
