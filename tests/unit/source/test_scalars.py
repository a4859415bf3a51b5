"""Plain scalars by the core schema of YAML 1.2."""

from __future__ import annotations

import math

import pytest

from scenecc.source.events import PlainKeys, PlainValues, resolve_scalar

VALUES = {
    "true": True, "True": True, "TRUE": True, "false": False, "False": False, "FALSE": False,
    "": None, "~": None, "null": None, "Null": None, "NULL": None,
    "0": 0, "12": 12, "-12": -12, "+12": 12, "012": 12, "-012": -12, "09": 9,
    "0o17": 15, "0x1F": 31, "0xff": 255,
    "1.": 1.0, ".5": 0.5, "-.5": -0.5, "+.5": 0.5, "1.5": 1.5, "-0.0": -0.0, "0.123456789": 0.123456789,
    "1e3": 1000.0, "1E3": 1000.0, "1e+3": 1000.0, "1.5e-3": 0.0015, ".5e1": 5.0, "01.5": 1.5, "12e03": 12000.0,
    "-00000000000000000000000000012.500": -12.5, "12345678901234567890123.125": 12345678901234567890123.125,
    ".inf": math.inf, ".Inf": math.inf, ".INF": math.inf, "-.inf": -math.inf, "+.inf": math.inf, "-.INF": -math.inf,
}  # fmt: skip

STRINGS = [
    "yes", "no", "on", "off", "y", "n", "Yes", "NO", "tRue", "nULL", "none", "None", "nil", "inf", "nan", "NaN",
    "12:30", "1:2", "1_000", "1,000", "0b101", "0o8", "0x", "0xG", "-0x1F", "+0o7", "0X1F", "0O7",
    ".", "-", "+", "e3", "1e", "1e+", ".e1", "1.2.3", "--1", "+-1", "1-", "-.nan", "+.nan", ".iNf", "infinity", "+inf",
    "-nan", "-infinity", "2001-12-14", "2001-12-14t21:59:43.10-05:00", "=", "<<", "1e3.5", "1 2",
    "١٢", "１", "٣.٥", "²", "1.5٣", "0.1٣٣",
]  # fmt: skip


@pytest.mark.parametrize(("text", "value"), VALUES.items())
def test_plain_scalars_follow_the_core_schema(text: str, value: object) -> None:
    for found in (resolve_scalar(text), PlainValues()[text]):
        assert type(found) is type(value)
        assert found == value
        assert math.copysign(1, found or 0) == math.copysign(1, value or 0)  # pyright: ignore[reportArgumentType]


@pytest.mark.parametrize("text", [".nan", ".NaN", ".NAN"])
def test_nan_is_a_float(text: str) -> None:
    value = resolve_scalar(text)
    assert isinstance(value, float)
    assert math.isnan(value)


@pytest.mark.parametrize("text", STRINGS)
def test_other_plain_scalars_are_strings(text: str) -> None:
    assert resolve_scalar(text) == PlainValues()[text] == text


@pytest.mark.parametrize("text", ["1e400", "-1e400", "9" * 400 + ".5", "1" * 101, "0x" + "f" * 101, "1" * 100_000])
def test_numbers_out_of_range_are_refused(text: str) -> None:
    with pytest.raises(OverflowError):
        resolve_scalar(text)
    assert PlainValues()[text] is None
    assert PlainKeys()[text] is None


def test_long_numbers_in_range_are_read() -> None:
    assert resolve_scalar("0." + "3" * 10_000) == 1 / 3
    assert resolve_scalar("1" * 100) == int("1" * 100)
    assert resolve_scalar("1e-999") == 0.0


@pytest.mark.parametrize("text", ["12", "1.5", "true", "~", "", "<<", ".inf"])
def test_plain_keys_must_be_strings(text: str) -> None:
    assert PlainKeys()[text] is None
    assert PlainKeys()["yes"] == "yes"
