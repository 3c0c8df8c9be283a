"""Ways to damage files, each decided by a seeded source of chance alone."""

import copy
import io
import json
import random
import struct
import tomllib
import zipfile
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

import numpy as np
import tomli_w

Mutation = Callable[[bytes, random.Random], bytes]

TOKENS: tuple[bytes, ...] = (
    *(b"", b"\0", b"\xff\xfe", b"\xef\xbb\xbf", b"\r", b"\n\n", b",", b",,,,,,,,", b";", b"\t"),
    *(b'"', b'"""', b"'", b"[", b"]", b"{", b"}", b"[[views]]\n", b"=", b"#", b".", b"a.b.c"),
    *(b"nan", b"-nan", b"inf", b"-inf", b"1e400", b"-1", b"0", b"0x", b"true", b"null", b"None"),
    *(b"30000000", b"-30000000", b"2147483648", b"9223372036854775808", b"9" * 400, b"9" * 5000),
    *(b"[" * 3000, b"{" * 3000, b'{"a":' * 3000, b"a." * 3000, b"x" * 70_000),
    *(b"\x1b[31m\x1b]0;t\x07", "\u202e\u2066".encode(), "\x85\x9b".encode(), "\ud7ff٣".encode()),
    *(b"../../../etc/passwd", b"/dev/zero", b"%d", b"%09999999999d", b"%s", b"NUL", b"http://x/"),
)
"""What has brought readers down, theirs or others'."""

HOSTILE: tuple[Any, ...] = (
    *(None, True, False, 0, -1, 1, 2, 0.5, -0.0, 1e308, float("nan"), float("inf"), 10**400),
    *(30_000_000, 2**31, 2**63, -(2**63) - 1),
    *("", " ", "x", "0", "nan", "\x1b[31m", "\u202e", "a/b"),
    *([], {}, [[]], [{}], [None], ["x"], [0.0] * 3, [1, [2]], {"a": 1}, {"": {}}, "x" * 70_000),
    *("../x", "/dev/zero", "%06d", [True] * 3, list(range(100)), {"name": []}),
)
"""Values of every kind, where another one belongs."""


def mutated_bytes(content: bytes, choose: random.Random) -> bytes:
    """Wrong bits and bytes, an early end, something left out, twice, elsewhere or put in."""
    data = bytearray(content)
    for _ in range(choose.choice([1, 1, 2, 5])):
        size = max(len(data), 1)
        at = choose.randrange(size)
        end = min(size, at + choose.choice([1, 2, 8, 64, 1024]))
        match choose.randrange(8):
            case 0 if data:
                data[at] ^= 1 << choose.randrange(8)
            case 1 if data:
                for _ in range(choose.choice([1, 20, 200])):
                    data[choose.randrange(len(data))] = choose.randrange(256)
            case 2:
                del data[at:]
            case 3:
                del data[at:end]
            case 4:
                data[at:at] = data[at:end] * choose.choice([1, 2, 50])
            case 5:
                data[at:at] = choose.choice(TOKENS)
            case 6:
                data[at:end] = choose.choice(TOKENS)
            case _:
                number = choose.choice([0, 1, 0x7F, 0xFF, 0xFFFF, 0x7FFFFFFF, 0xFFFFFFFF])
                data[at : at + 4] = struct.pack("<I", number)
    return bytes(data)


def mutated_lines(content: bytes, choose: random.Random) -> bytes:
    """Lines left out, twice, in another order; words replaced."""
    lines = content.split(b"\n")
    for _ in range(choose.choice([1, 1, 3])):
        at = choose.randrange(len(lines))
        match choose.randrange(6):
            case 0 if len(lines) > 1:
                del lines[at]
            case 1:
                lines.insert(choose.randrange(len(lines)), lines[at])
            case 2:
                choose.shuffle(lines)
            case 3:
                lines.insert(at, choose.choice(TOKENS))
            case _:
                sign = choose.choice([b",", b"\t", b" ", b"=", b".", b":"])
                words = lines[at].split(sign)
                words[choose.randrange(len(words))] = choose.choice(TOKENS)
                lines[at] = sign.join(words)
    return b"\n".join(lines)


def mutated_tree(tree: Any, choose: random.Random) -> Any:
    """Plain data in which a value, or some, are of another kind, gone or twice."""
    root = [copy.deepcopy(tree)]
    for _ in range(choose.choice([1, 1, 2, 4])):
        places = list(_places(root))
        named = {str(key): (holder, key) for holder, key in choose.sample(places, len(places))}
        holder, key = named[choose.choice(sorted(named))]
        match choose.randrange(8):
            case 0 if holder is not root:
                del holder[key]
            case 1 if isinstance(holder, list) and holder is not root:
                holder.insert(key, copy.deepcopy(holder[key]))
            case 2 if isinstance(holder, dict):
                name = choose.choice(["", "name", "x\x1b[0m", "a.b", "\u202e", key])
                holder[name] = holder.pop(key)
            case 3:
                other, its = choose.choice(places)
                holder[key] = copy.deepcopy(other[its])
            case _:
                holder[key] = copy.deepcopy(choose.choice(HOSTILE))
    return root[0]


def _places(root: Any) -> Any:
    """Every list or table of a tree with each of its keys."""
    for key in range(len(root)) if isinstance(root, list) else list(root):
        yield root, key
        if isinstance(root[key], list | dict):
            yield from _places(root[key])


def mutated_json(content: bytes, choose: random.Random) -> bytes:
    """Another tree two times out of three, else spoilt text."""
    if choose.randrange(3):
        with suppress(ValueError):  # spoilt before
            return json.dumps(mutated_tree(json.loads(content), choose)).encode()
    return mutated_table(content, choose)


def mutated_toml(content: bytes, choose: random.Random) -> bytes:
    """The same for TOML."""
    if choose.randrange(3):
        with suppress(TypeError, AttributeError):  # it has no null, and is a table
            return tomli_w.dumps(mutated_tree(tomllib.loads(content.decode()), choose)).encode()
    return mutated_table(content, choose)


def mutated_table(content: bytes, choose: random.Random) -> bytes:
    """Lines and words of a text file, sometimes its bytes."""
    return choose.choice([mutated_lines, mutated_lines, mutated_bytes])(content, choose)


def mutated_arrays(content: bytes, choose: random.Random) -> bytes:
    """An ``.npz`` with arrays of other kinds and shapes, lying headers, wrong members."""
    if choose.randrange(4) == 0:
        return mutated_bytes(content, choose)
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        members = {info.filename: archive.read(info) for info in archive.infolist()}
    name = choose.choice(sorted(members))
    spoilt = choose.choice([mutated_bytes, _lying_header, _other_array])(members.pop(name), choose)
    return archived(members | {name: spoilt} if choose.randrange(8) else members)


def archived(members: Mapping[str, bytes]) -> bytes:
    """An archive of members by their file names."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    return file.getvalue()


def with_meta(content: bytes, change: Callable[[Any], Any]) -> bytes:
    """An ``.npz`` whose array ``meta`` holds other JSON."""
    with np.load(io.BytesIO(content), allow_pickle=False) as stored:
        arrays = dict(stored)
    arrays["meta"] = np.array(json.dumps(change(json.loads(str(arrays["meta"])))))
    file = io.BytesIO()
    np.savez_compressed(file, **arrays)
    return file.getvalue()


def mutated_meta(content: bytes, choose: random.Random) -> bytes:
    """An ``.npz`` in whose meta something is of another kind."""
    return with_meta(content, lambda meta: mutated_tree(meta, choose))


def member(descr: Any, shape: Any, data: bytes = b"", *, order: Any = False) -> bytes:
    """A member of an archive of arrays whose header says this, whatever the data are."""
    header = str({"descr": descr, "fortran_order": order, "shape": shape})
    padded = header + " " * (-(len(header) + 11) % 64) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(padded)) + padded.encode("latin1") + data


def _lying_header(data: bytes, choose: random.Random) -> bytes:
    shape = choose.choice(
        [(), (0,), (10**18,), (3, 10**9), (-1,), (2**40, 0), (1.5,), "x", None, (1,) * 40, (True,)]
    )
    descr = choose.choice(
        ["<f8", "<i8", "|O", "<U1000000000", "|V8", "<M8[ns]", "x", [("a", "<f8")], ">f8", "|b1", 5]
    )
    return member(descr, shape, data[128:], order=choose.choice([False, True, "x"]))


def _other_array(data: bytes, choose: random.Random) -> bytes:
    array = np.load(io.BytesIO(data), allow_pickle=False)
    others = (
        lambda a: a[None],
        lambda a: a.ravel(),
        lambda a: a[:-1] if a.ndim else a,
        lambda a: np.zeros(choose.choice([(0,), (), (3, 0)]), dtype=a.dtype),
        lambda a: np.full(a.shape, choose.choice([np.nan, np.inf, 1e308, -1, 2**62]), float),
        lambda a: np.array([0, 30_000_000, 2**62]),
        lambda a: np.array(str(a)),
    )
    file = io.BytesIO()
    np.save(file, choose.choice(others)(array), allow_pickle=False)
    return file.getvalue()
