"""Relaxed matching: patterns of which the corners of a boundary may fall anywhere.

Read family (the patterns: complete families), corner_placement (where corners may fall on them:
the tables of marked patterns) and bestmarked (the one that fills a boundary best).
"""
