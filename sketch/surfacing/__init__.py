"""Surface patches for curve networks: network -> cycles -> chords -> pieces -> mesh.

After Abbasinejad, Joshi, Amenta, Simons and Grimm, "Surface patches for 3D sketching" (2013).
"""
