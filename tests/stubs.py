"""The writer of type stubs for interface packages.

`python -m tests.stubs FOLDER [package=DIRECTORY ...]`

Type checkers cannot run an import hook; they read the stubs.
"""

from __future__ import annotations

import sys
from pathlib import Path

from archo_tui.ros.embedded import HERE
from archo_tui.ros.embedded.idl import FLOATS, INTEGERS, TYPE_CODES, FieldType, Section, parse
from archo_tui.ros.embedded.import_hook import KINDS

_HEADER = "# Made by tests.stubs from the interface files; a test keeps it fresh.\n"


def stubs(packages: dict[str, Path]) -> dict[str, str]:
    """Relative path -> text of every stub of these packages."""
    made: dict[str, str] = {}
    for package, folder in sorted(packages.items()):
        made[f"{package}/__init__.pyi"] = _HEADER
        for kind in KINDS:
            paths = sorted((folder / kind).glob(f"*.{kind}"))
            if paths:
                made[f"{package}/{kind}/__init__.pyi"] = _module(package, kind, paths)
    return made


def shared_packages() -> dict[str, Path]:
    """The packages that the engine brings."""
    return {path.name: path for path in (HERE / "share").iterdir() if path.is_dir()}


def _module(package: str, kind: str, paths: list[Path]) -> str:
    body: list[str] = []
    imports: set[str] = set()
    for path in paths:
        sections = parse(path, package)
        if kind == "msg":
            body += _message(path.stem, sections[0], f"{package}.{kind}", imports, "")
            continue
        names = ("Request", "Response") if kind == "srv" else ("Goal", "Result", "Feedback")
        body.append(f"class {path.stem}:")
        for name, section in zip(names, sections, strict=True):
            body += _message(name, section, f"{package}.{kind}", imports, "    ")
        if kind == "action":
            body.append("    Impl: ClassVar[Any]")
        body.append("")
    lines = [_HEADER, "from typing import Any, ClassVar", ""]
    lines += [f"import {name}" for name in sorted(imports)]
    return "\n".join([*lines, "", *body]).rstrip() + "\n"


def _message(name: str, section: Section, module: str, imports: set[str], indent: str) -> list[str]:
    lines = [f"{indent}class {name}:"]
    for constant, type_of, _ in section.constants:
        lines.append(f"{indent}    {constant}: ClassVar[{_python(type_of, module, imports)}]")
    arguments = ["self"]
    if section.fields:
        arguments.append("*")
    for field in section.fields:
        kind = _python(field.type, module, imports)
        lines.append(f"{indent}    {field.name}: {kind}")
        arguments.append(f"{field.name}: {kind} = ...")
    lines.append(f"{indent}    def __init__({', '.join(arguments)}) -> None: ...")
    lines.append(f"{indent}    @classmethod")
    lines.append(f"{indent}    def get_fields_and_field_types(cls) -> dict[str, str]: ...")
    lines.append(f"{indent}    def __received__(self) -> Any: ...")
    return [*lines, ""]


def _python(kind: FieldType, module: str, imports: set[str]) -> str:
    if "/" in kind.base:
        package, name = kind.base.split("/")
        if f"{package}.msg" == module:
            single = name
        else:
            imports.add(f"{package}.msg")
            single = f"{package}.msg.{name}"
    elif kind.base in INTEGERS:
        single = "int"
    elif kind.base in FLOATS:
        single = "float"
    else:
        single = {"bool": "bool", "byte": "bytes"}.get(kind.base, "str")
    if not kind.is_array:
        return single
    # array.array and list share no type that can be written so simply
    return "Any" if kind.base in TYPE_CODES else f"list[{single}]"


def main(words: list[str]) -> None:
    """Write the stubs below the folder given first."""
    target = Path(words[0])
    packages = shared_packages() | {
        name: Path(folder) for name, _, folder in (word.partition("=") for word in words[1:])
    }
    for relative, text in stubs(packages).items():
        path = target / relative
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
