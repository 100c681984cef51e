"""XML and YAML launch files as one kind of tree."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.parsers import expat

import yaml

from archo_tui import regular_files
from archo_tui.launch.stand_ins.core import Place, SubstitutionFailure
from archo_tui.nearest import nearest_hint
from archo_tui.yaml_text import bounded_yaml
from archo_tui.yaml_text.core_schema import YamlFault

_YAML = yaml.constructor.SafeConstructor()  # Of YAML 1.1, by which launch reads values.
ENDINGS = {".xml": "xml", ".launch": "xml", ".yaml": "yaml", ".yml": "yaml"}


class Element:
    """An element of a launch file, whose attributes and sub-elements are asked for once each.

    XML has texts; the values of YAML must have the type that is asked for, or be texts, which may
    have substitutions.
    """

    def __init__(self, tag: str, place: Place, is_yaml: bool) -> None:
        self.tag, self.place = tag, place
        self.attributes: dict[str, Any] = {}
        self.elements: list[Element] = []
        self.has_children = not is_yaml  # In YAML there is a list of them, which may be empty.
        self._is_yaml = is_yaml
        self._asked: set[str] = set()

    def get(self, name: str, kind: type = str) -> Any:
        """Return an attribute, of a type or a text; None if there is none.

        With `NAME-sep` of XML it is a list of texts. The type `object` stands for any.
        """
        self._asked.update((name, f"{name}-sep"))
        value, separator = self.attributes.get(name), self.attributes.get(f"{name}-sep")
        if isinstance(value, str) and separator is not None:
            return value.split(separator)
        if value is None or isinstance(value, (kind, str)):
            return value
        what = f"{kind.__name__} is wanted, not {value!r}"
        if kind is str:
            what = f'a text is wanted: "{str(value).lower()}"'
        raise self.failure(f"{name} of {self.tag}: {what}")

    def need(self, name: str, kind: type = str) -> Any:
        """Return an attribute that must be there."""
        value = self.get(name, kind)
        if value is None:
            raise self.failure(f"{self.tag} has no {name}{nearest_hint(name, self.attributes)}")
        return value

    def named(self, tag: str) -> list[Element]:
        """Return the sub-elements of a tag."""
        self._asked.add(tag)
        if tag in self.attributes:
            raise self.failure(f"{tag} of {self.tag}: a list is wanted, as `{tag}: [{{...}}]`")
        return [element for element in self.elements if element.tag == tag]

    def others(self, *left_out: str) -> list[Element]:
        """Return all sub-elements but those of some tags: actions."""
        if not self.has_children:
            raise self.failure(f"{self.tag} has no list of actions: write it as `children:`")
        found = [element for element in self.elements if element.tag not in left_out]
        self._asked.update(element.tag for element in found)
        return found

    def check_all_asked(self) -> None:
        """Raise SubstitutionFailure for a part that nobody has asked for."""
        for name in [*self.attributes, *(element.tag for element in self.elements)]:
            if name not in self._asked:
                near = nearest_hint(name, self._asked)
                raise self.failure(f"{self.tag} takes no {name}{near}")

    def failure(self, text: str) -> SubstitutionFailure:
        return SubstitutionFailure(text, self.place)


def read(path: str) -> Element:
    """Return the root element of a launch file; raise SubstitutionFailure."""
    if ENDINGS[os.path.splitext(path)[1]] == "yaml":
        return _read_yaml(path)
    return _XmlReader(path).root


class _XmlReader:
    """An XML file that is read. Entities are refused: a few can expand to gigabytes."""

    def __init__(self, path: str) -> None:
        self._path, self._parser = path, expat.ParserCreate()
        self._open: list[Element] = []
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.EntityDeclHandler = self._refuse
        try:
            self._parser.Parse(regular_files.read(Path(path)), True)
        except expat.ExpatError as error:
            why = f"not XML: {expat.ErrorString(error.code)}"
            raise SubstitutionFailure(why, Place(path, error.lineno)) from None
        except (LookupError, ValueError):  # As for `encoding="none such"`.
            why = "not XML: its encoding is not known"
            raise SubstitutionFailure(why, Place(path, 1)) from None

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        element = Element(tag, Place(self._path, self._parser.CurrentLineNumber), False)
        element.attributes = attributes
        if self._open:
            self._open[-1].elements.append(element)
        else:
            self.root = element
        self._open.append(element)

    def _end(self, _tag: str) -> None:
        self._open.pop()

    def _refuse(self, name: str, *_: object) -> None:
        place = Place(self._path, self._parser.CurrentLineNumber)
        raise SubstitutionFailure(f"entities (&{name};) are not read: write it out", place)


def _read_yaml(path: str) -> Element:
    try:
        text = bounded_yaml.read(Path(path))
        bounded_yaml.node_of(text)  # Raises for what never ends, or is no YAML.
    except YamlFault as fault:
        raise SubstitutionFailure(fault.reason, Place(path, fault.line)) from None
    except bounded_yaml.YamlError as error:  # It cannot be read; its text begins with the file.
        why = str(error).removeprefix(f"{path}:").strip()
        raise SubstitutionFailure(why, Place(path, 0)) from None
    node = yaml.compose(text, Loader=yaml.SafeLoader)
    if not isinstance(node, yaml.MappingNode) or len(node.value) != 1:
        raise SubstitutionFailure("it does not begin with launch: alone", Place(path, 1))
    [(key, content)] = node.value
    return _yaml_element(path, key, content)


def _yaml_element(path: str, key: yaml.Node, node: yaml.Node) -> Element:
    element = Element(str(key.value), Place(path, key.start_mark.line + 1), True)
    if isinstance(node, yaml.SequenceNode):
        element.elements, element.has_children = [*_yaml_entities(path, node)], True
    elif isinstance(node, yaml.MappingNode):
        for name, content in node.value:
            if name.value == "children" and isinstance(content, yaml.SequenceNode):
                element.elements += _yaml_entities(path, content)
                element.has_children = True
            elif _is_list_of_maps(content):
                element.elements += [_yaml_element(path, name, part) for part in content.value]
            else:
                element.attributes[name.value] = _YAML.construct_document(content)
    else:
        raise element.failure(f"{element.tag}: a mapping or a list is wanted")
    return element


def _yaml_entities(path: str, node: yaml.SequenceNode) -> Iterator[Element]:
    for part in node.value:
        if not isinstance(part, yaml.MappingNode) or len(part.value) != 1:
            place = Place(path, part.start_mark.line + 1)
            raise SubstitutionFailure("each entry is one action, as `- node:`", place)
        [(key, content)] = part.value
        yield _yaml_element(path, key, content)


def _is_list_of_maps(node: yaml.Node) -> bool:
    parts = node.value if isinstance(node, yaml.SequenceNode) else []
    return bool(parts) and all(isinstance(part, yaml.MappingNode) for part in parts)
