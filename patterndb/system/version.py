"""The version of the project, for those who need it without the face."""

__version__ = "0.1.0"
