"""Films in and out, frame by frame with their times."""

from helimag.vision.films.pictures import Picture, read_picture
from helimag.vision.films.reading import Film, Frame
from helimag.vision.films.streams import ahead, together
from helimag.vision.films.writing import FilmWriter

__all__ = ["Film", "FilmWriter", "Frame", "Picture", "ahead", "read_picture", "together"]
