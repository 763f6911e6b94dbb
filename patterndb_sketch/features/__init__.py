"""Feature curves on models of any quality, and the shape model that they give.

After the paper on a sketching interface for feature curve recovery of free-form surfaces.
"""
