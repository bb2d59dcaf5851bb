"""Write the Python modules of .msg and .srv files: `python -m sunset_ros.generator FOLDER PACKAGE`."""

import argparse
from pathlib import Path

from sunset_ros.generator.modules import generate


def main() -> None:
    """Write the modules that differ from their definitions, and print their paths."""
    parser = argparse.ArgumentParser(
        prog="python -m sunset_ros.generator",
        description="Write the typed Python modules of the messages and services below a folder: "
        "FOLDER/my_msgs/msg/*.msg makes PACKAGE.my_msgs.msg.",
    )
    parser.add_argument(
        "folder", metavar="FOLDER", type=Path, help="the folder of the Python package PACKAGE"
    )
    parser.add_argument("package", metavar="PACKAGE", help="the Python package, such as my_nodes")
    arguments = parser.parse_args()
    for path, text in generate(arguments.folder, arguments.package).items():
        file = arguments.folder / path
        if not file.is_file() or file.read_text(encoding="utf-8") != text:
            file.write_text(text, encoding="utf-8")
            print(f"written: {path}")


if __name__ == "__main__":
    main()
