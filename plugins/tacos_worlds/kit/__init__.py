"""Parts that families of worlds are built with; no family by itself.

===============  ============================================================================================
``mesh``         meshes as they are put together, with ``shapes``
``piece``        a thing of several materials: furniture, vehicles, people
``finishes``     materials by style, with ``textures`` and ``colours``
``people``       people who stand, sit and walk
``walk``         an agent's walk along a path, and the stretches that become an episode
``rectangle``    rectangles along the axes
``sky``          daylight
``class_names``  names of the classes of objects
``mesh_files``   meshes of users, read safely into ``models``
``world_key``    what a world's light is kept by
===============  ============================================================================================
"""
