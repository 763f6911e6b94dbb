"""Here for its place, as in the folder above: the tests find hands.py."""
