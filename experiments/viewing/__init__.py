"""Experiments in three dimensions: live in a browser, as a page that needs no server, as a Rerun recording."""
