"""Found on the path of a worker that is to fail while it starts."""

import os

os._exit(7)
