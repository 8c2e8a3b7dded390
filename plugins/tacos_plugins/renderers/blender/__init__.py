"""`renderer.blender`: path tracing with Blender's Cycles, in a process of its own."""
