"""Write the Python modules of .msg and .srv files: `python -m sunset_ros.generator FOLDER PACKAGE`."""

import argparse
import sys
from pathlib import Path

from sunset_ros.generator.modules import generate


def main() -> int:
    """Return 1 if --check found a module that differs from its definitions, else 0."""
    parser = argparse.ArgumentParser(
        prog="python -m sunset_ros.generator",
        description="Write the typed Python modules of the messages and services below a folder: "
        "FOLDER/my_msgs/msg/*.msg makes PACKAGE.my_msgs.msg.",
    )
    parser.add_argument(
        "folder", metavar="FOLDER", type=Path, help="the folder of the Python package PACKAGE"
    )
    parser.add_argument("package", metavar="PACKAGE", help="the Python package, such as my_nodes")
    parser.add_argument("--check", action="store_true", help="write nothing, only name the files that differ")
    arguments = parser.parse_args()
    stale = 0
    for path, text in generate(arguments.folder, arguments.package).items():
        file = arguments.folder / path
        if file.is_file() and file.read_text(encoding="utf-8") == text:
            continue
        stale += 1
        print(f"{'differs' if arguments.check else 'written'}: {path}")
        if not arguments.check:
            file.write_text(text, encoding="utf-8")
    return int(arguments.check and stale > 0)


if __name__ == "__main__":
    sys.exit(main())
