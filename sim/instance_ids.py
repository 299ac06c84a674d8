"""Images that say at each pixel which part it shows, and where a pixel is: needs neither physics nor OpenGL."""

PIXEL_CENTER = 0.5  # OpenGL samples pixel i at i + 0.5
NO_INSTANCE = -1  # of a pixel that shows no part
