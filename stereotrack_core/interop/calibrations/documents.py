"""The content of a stranger's file as plain data: TOML, YAML, JSON, XML, MAT and INI."""

import zlib
from collections.abc import Mapping
from configparser import ConfigParser
from configparser import Error as ConfigError
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal
from xml.etree import ElementTree

import numpy as np
import yaml

from stereotrack_core.errors import InputError
from stereotrack_core.limited_process import read_apart
from stereotrack_core.plain_data import DEEPEST, checked_tree
from stereotrack_core.reading import MB, decoding, open_file, parsed_json, read_text
from stereotrack_core.recording.toml_table import load_toml

Kind = Literal["toml", "yaml", "json", "xml", "mat", "ini"]

_TEXT_BYTES = 8 * MB  # a calibration as text, with all corners of the board that some tools keep
_YAML_BYTES = MB  # which takes some seconds to read

_MAT_BYTES = 64 * MB
_NO_MAT = "this is not a MAT file that can be read"
_MOST_NUMBERS = 10_000  # larger arrays hold pictures or points, no calibration
_REMEDY = "Use another copy of the file."
_HDF5_MAGIC = b"\x89HDF"


@dataclass(frozen=True, eq=False)
class Document:
    """What a file holds: tables, lists, texts and numbers, or for XML its root element."""

    path: Path
    kind: Kind
    content: Any

    @property
    def where(self) -> str:
        """The file, as error messages name it."""
        return str(self.path)


def read_document(path: Path) -> Document:
    """Read a file by its content, TOML, MAT and INI by suffix; InputError if it is none of them."""
    suffix = path.suffix.lower()
    if suffix == ".toml":
        return Document(path, "toml", load_toml(path))
    if suffix == ".mat":
        return Document(path, "mat", _mat(path))
    text = read_text(path, _TEXT_BYTES).lstrip()
    if suffix in (".conf", ".ini"):
        return Document(path, "ini", _ini(text, path))
    if text.startswith("<"):
        return Document(path, "xml", _xml(text, path))
    kind: Kind = "json" if text.startswith("{") else "yaml"
    content = parsed_json(text, str(path)) if kind == "json" else _yaml(text, path)
    if not isinstance(content, Mapping):
        what = "this is not a calibration file: it holds no names with values"
        raise InputError(what, path, "Check that it is the right file.")
    return Document(path, kind, content)


class _Loader(yaml.SafeLoader):  # type: ignore[misc]
    """Plain data only, without aliases, which can make a small file huge."""

    def compose_node(self, parent: Any, index: Any) -> Any:
        if self.check_event(yaml.AliasEvent):
            raise yaml.YAMLError
        return super().compose_node(parent, index)

    def untagged(self, _tag: str, node: yaml.Node) -> Any:
        """What a tag such as ``!!opencv-matrix`` stands before."""
        if isinstance(node, yaml.MappingNode):
            return self.construct_mapping(node, deep=True)
        if isinstance(node, yaml.SequenceNode):
            return self.construct_sequence(node, deep=True)
        return str(node.value)


_Loader.add_multi_constructor("", _Loader.untagged)


def _yaml(text: str, path: Path) -> Any:
    if text.startswith("%YAML"):
        text = text.partition("\n")[2]  # OpenCV writes the directive in a way of its own
    if len(text) > _YAML_BYTES:
        what = f"the file has more than {_YAML_BYTES // MB} MB, too large for a calibration as YAML"
        raise InputError(what, path, "Keep only the cameras in it.")
    with decoding(path, "this is not valid YAML", _REMEDY):
        try:
            documents = yaml.load_all(text, _Loader)
            content = next((_plain(one) for one in documents if one is not None), None)
        except yaml.MarkedYAMLError as error:
            line = "" if error.problem_mark is None else f", line {error.problem_mark.line + 1}"
            what = "this is not valid YAML"
            raise InputError(what, f"{path}{line}", "Correct this line.") from None
        except yaml.YAMLError as error:
            raise ValueError from error
    checked_tree(content, str(path))
    return content


def _plain(value: Any, depth: int = 0) -> Any:
    """The same value of tables with texts as names, lists, texts and numbers."""
    if depth > DEEPEST:
        raise RecursionError
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist() if value.size <= _MOST_NUMBERS else None
    if isinstance(value, Mapping):
        return {str(key): _plain(one, depth + 1) for key, one in value.items()}
    if isinstance(value, list | tuple | set):
        return [_plain(one, depth + 1) for one in value]
    return value if isinstance(value, str | bool | int | float | None) else str(value)


def _ini(text: str, path: Path) -> Mapping[str, Mapping[str, str]]:
    """Sections with values by their names, all in lower case."""
    parser = ConfigParser(interpolation=None, strict=False)
    with decoding(path, "this is not a file of sections with values", _REMEDY):
        try:
            parser.read_string(text)
        except ConfigError as error:
            raise ValueError from error
    return {name.casefold(): dict(values) for name, values in parser.items() if name != "DEFAULT"}


def _xml(text: str, path: Path) -> ElementTree.Element:
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        what = "it declares XML entities, which no calibration needs"
        raise InputError(what, path, "Check that it is the right file.")
    # what Python's parser is warned of needs the declarations that were refused above
    with decoding(path, "this is not valid XML", _REMEDY):
        return ElementTree.fromstring(text)  # noqa: S314


def _mat(path: Path) -> Mapping[str, Any]:
    with open_file(path, _MAT_BYTES) as file:
        data = file.read(128)
    if data[:4] == _HDF5_MAGIC or data[:10] == b"MATLAB 7.3":
        remedy = "In MATLAB, save it with save(..., '-v7'), or write JSON with jsonencode."
        raise InputError("this is a MAT file of version 7.3, which cannot be read", path, remedy)
    with decoding(path, _NO_MAT, _REMEDY):
        if data[126:128] not in (b"IM", b"MI"):
            raise ValueError("it does not begin as one")
    return read_apart(_variables, path, _REMEDY)


def _variables(path: Path) -> dict[str, Any]:
    """Variables of a MAT file in this process, which SciPy's reader may end."""
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    with decoding(path, _NO_MAT, _REMEDY):
        try:
            found = loadmat(path, simplify_cells=True)
        except (MatReadError, zlib.error) as error:
            raise ValueError(str(error)) from error
        content = {name: _plain(one) for name, one in found.items() if not name.startswith("__")}
    checked_tree(content, str(path))
    return content
