import pytest

from sunset_ros.errors import InterfaceError
from sunset_ros.generator.definitions import (
    Constant,
    Field,
    FieldType,
    parse_message,
    parse_type,
    split_service,
)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("bool", FieldType("bool")),
        ("char", FieldType("uint8")),
        ("string<=5", FieldType("string", string_bound=5)),
        ("float64[]", FieldType("float64", is_array=True)),
        ("float64[9]", FieldType("float64", is_array=True, size=9)),
        ("string<=5[<=2]", FieldType("string", string_bound=5, is_array=True, limit=2)),
        ("Own[]", FieldType("pkg/msg/Own", is_array=True)),
        ("std_msgs/Header", FieldType("std_msgs/msg/Header")),
    ],
)
def test_a_type_is_read(text: str, expected: FieldType) -> None:
    assert parse_type(text, "pkg") == expected


@pytest.mark.parametrize(
    "text", ["float64[", "float64[-1]", "wstring", "bool<=5", "a/b/c", "8bit", "", "x[1][2]"]
)
def test_what_is_no_type_is_refused(text: str) -> None:
    with pytest.raises(InterfaceError, match="is not supported"):
        parse_type(text, "pkg")


@pytest.mark.parametrize("text", ["bool", "string<=5[<=2]", "float64[9]", "uint8[]", "std_msgs/Header[3]"])
def test_a_type_is_written_as_it_was_read(text: str) -> None:
    assert str(parse_type(text, "pkg")) == text


def test_constants_fields_defaults_and_comments_are_read() -> None:
    text = """
    # a comment
    int32 ANSWER = 42   # why not
    string HASH="#1"
    bool ON=true
    float32 HALF = 0.5
    byte B=255
    uint8 HEX=0x10
    string WORD=plain text
    int32 number -7
    string name "no # comment"
    bool flag true
    float64[] values [1.0, 2.5]
    string[2] words ["a", 'b']
    """
    definition = parse_message(text, "pkg/msg/Own")
    assert definition.constants == (
        Constant("int32", "ANSWER", 42),
        Constant("string", "HASH", "#1"),
        Constant("bool", "ON", True),
        Constant("float32", "HALF", 0.5),
        Constant("byte", "B", b"\xff"),
        Constant("uint8", "HEX", 16),
        Constant("string", "WORD", "plain text"),
    )
    assert definition.fields == (
        Field(FieldType("int32"), "number", -7),
        Field(FieldType("string"), "name", "no # comment"),
        Field(FieldType("bool"), "flag", True),
        Field(FieldType("float64", is_array=True), "values", [1.0, 2.5]),
        Field(FieldType("string", is_array=True, size=2), "words", ["a", "b"]),
    )


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("int32", "Line 1 of pkg/msg/Own is neither a field nor a constant: 'int32'"),
        ("\nint32 2x", "Line 2 of"),
        ("int32 X=1.5", "'1.5' is not a value of type int32"),
        ("bool x maybe", "'maybe' is not a value of type bool"),
        ("byte B=256", "'256' is not a value of type byte"),
    ],
)
def test_a_malformed_line_is_refused(text: str, expected: str) -> None:
    with pytest.raises(InterfaceError, match=expected):
        parse_message(text, "pkg/msg/Own")


def test_a_service_has_a_request_and_a_response() -> None:
    assert split_service("bool a\n---\nint8 b\n", "pkg/srv/Own") == ("bool a\n", "int8 b\n")


@pytest.mark.parametrize("text", ["bool a", "---\n---\n"])
def test_a_service_without_one_separator_is_refused(text: str) -> None:
    with pytest.raises(InterfaceError, match="needs one line '---'"):
        split_service(text, "pkg/srv/Own")
