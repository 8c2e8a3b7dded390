"""Worlds built and lit once per machine: a store on disk, shared by processes and by studies.

================  ==========================================================================================
``store``         entries by content key: locks, the size limit, what damage costs
``entry_file``    one entry on disk, checked when it is read
``structures``    frozen dataclasses of arrays as plain data, and back
``fingerprints``  content keys of code, settings and files
``episodes``      the store that simulations are offered (hook `tacos_episode_stores`)
``commands``      ``tacos cache``
================  ==========================================================================================
"""
