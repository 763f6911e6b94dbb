"""The tools of retopology: functions from a network, and what the user did, to an edit of it.

A tool that cannot do what it was asked for raises RefusedError; the network is never half changed.
"""
