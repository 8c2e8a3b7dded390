"""Studies of jobs for which engineers have converged on a class of cameras, held against that class."""
