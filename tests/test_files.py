"""One reader of TOML: whatever the text, a dictionary or one clear refusal."""

import pytest

from helimag.errors import InputError
from helimag.files import toml_tables


def test_tables_are_read():
    assert toml_tables('a = 1\n[b]\nc = "x"', "it") == {"a": 1, "b": {"c": "x"}}


@pytest.mark.parametrize("text", ["a =", "a = " + "[" * 5000, "a = " + "1" * 5000])
def test_what_is_not_toml_is_refused_by_name(text):
    with pytest.raises(InputError, match=r"it .*TOML"):
        toml_tables(text, "it")
