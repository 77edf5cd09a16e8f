"""Training, evaluation and export of jostle's networks."""

__version__ = "0.1.0"
