"""Marked patterns: patterns with the places where a boundary's corners fall.

Read patterntable (the patterns), markplaces (every choice of marks on one), marked (the table of
marked patterns) and bestmarked (the one that fills a boundary best).
"""
