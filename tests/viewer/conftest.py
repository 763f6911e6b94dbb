"""Here for its place: pytest puts the folder of a conftest on the path, and so the folders below
find events.py and viewer_disks.py."""
