"""Films in and out, frame by frame with their times."""

from helimag.vision.films.pictures import DEPTHS, Picture, bits_of, eight_bits, read_raw
from helimag.vision.films.reading import Film, Frame
from helimag.vision.films.streams import ahead, together
from helimag.vision.films.writing import FilmWriter

__all__ = ["DEPTHS", "Film", "FilmWriter", "Frame", "Picture", "ahead", "bits_of", "eight_bits", "read_raw", "together"]
