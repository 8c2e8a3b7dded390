"""Recordings of other programs, made into a folder that is read here: frames, ``times.csv``, ``camera.yaml``.

============ ================================================================
``found``    frames of one camera, each with its time and exposure
``folders``  a table of times and exposures; EuRoC, TUM and KITTI folders
``streams``  video files and ROS bags
``writing``  the folder, and what is doubtful about the frames
``commands`` ``tacos recordings``
============ ================================================================
"""
