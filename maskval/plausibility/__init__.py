"""Whether poses, masks and cameras can belong together at all: wrong units, frames and conventions."""
