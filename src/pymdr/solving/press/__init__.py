"""A surface pressed by boundary elements."""

from pymdr.solving.press.value import PressedSurface, open_pressed_surface
from pymdr.solving.press.verb import bytes_of, pixels_of, press

__all__ = ["PressedSurface", "bytes_of", "open_pressed_surface", "pixels_of", "press"]
