"""Images and arrays in files from outside, read safely on top of `tacos_framework.files`.

``image_headers``  what an image file says of its size, and whether it is whole
``images``         samples of an image file
``arrays``         arrays of numbers (.npy, .npz)
``camera_images``  files of cameras, RAW among them: images of captures, frames for measurements of noise
``exposure_names`` exposure times in the names of files
``table_columns``  columns of tables by their headings
``dates``          dates with a time of day

No plugin of its own: what the packages of plugins have in common here, the core has no need of.
"""
