"""Depth from stereo by PSMNet (Chang and Chen 2018), trained together with the cameras."""
