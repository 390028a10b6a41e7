"""MessagePack, as far as sessions use it: reading alone."""

from __future__ import annotations

import struct
from typing import Any

# Nested deeper than any message is.
_DEEPEST = 64


class NotMessagePack(ValueError):
    """Bytes that are no MessagePack value."""


class _Unpacker:
    def __init__(self, data: bytes) -> None:
        self.data = memoryview(data)
        self.at = 0

    def take(self, count: int) -> bytes:
        end = self.at + count
        if end > len(self.data):
            raise NotMessagePack(f"{count} bytes announced at byte {self.at}, {len(self.data) - self.at} there")
        taken = bytes(self.data[self.at : end])
        self.at = end
        return taken

    def number(self, form: str) -> Any:
        return struct.unpack(form, self.take(struct.calcsize(form)))[0]

    def value(self, depth: int = 0) -> Any:
        if depth > _DEEPEST:
            raise NotMessagePack(f"values nested deeper than {_DEEPEST}")
        first = self.take(1)[0]
        if first < 0x80:
            return first
        if first < 0x90:
            return self.map(first & 0x0F, depth)
        if first < 0xA0:
            return self.list(first & 0x0F, depth)
        if first < 0xC0:
            return self.text(first & 0x1F)
        if first >= 0xE0:
            return first - 0x100
        match first:
            case 0xC0:
                return None
            case 0xC2:
                return False
            case 0xC3:
                return True
            case 0xC4 | 0xC5 | 0xC6:
                return self.take(self.number({0xC4: ">B", 0xC5: ">H", 0xC6: ">I"}[first]))
            case 0xCA:
                return self.number(">f")
            case 0xCB:
                return self.number(">d")
            case 0xCC | 0xCD | 0xCE | 0xCF:
                return self.number({0xCC: ">B", 0xCD: ">H", 0xCE: ">I", 0xCF: ">Q"}[first])
            case 0xD0 | 0xD1 | 0xD2 | 0xD3:
                return self.number({0xD0: ">b", 0xD1: ">h", 0xD2: ">i", 0xD3: ">q"}[first])
            case 0xD9 | 0xDA | 0xDB:
                return self.text(self.number({0xD9: ">B", 0xDA: ">H", 0xDB: ">I"}[first]))
            case 0xDC | 0xDD:
                return self.list(self.number({0xDC: ">H", 0xDD: ">I"}[first]), depth)
            case 0xDE | 0xDF:
                return self.map(self.number({0xDE: ">H", 0xDF: ">I"}[first]), depth)
        raise NotMessagePack(f"byte {first:#04x} at {self.at - 1} begins no value that sessions have")

    def text(self, count: int) -> str:
        try:
            return self.take(count).decode("utf-8")
        except UnicodeDecodeError as error:
            raise NotMessagePack(f"text before byte {self.at} is not UTF-8: {error}") from error

    def list(self, count: int, depth: int) -> list[Any]:
        # One byte each at least: a count that promises more is no list.
        if count > len(self.data) - self.at:
            raise NotMessagePack(f"{count} values announced at byte {self.at}, {len(self.data) - self.at} bytes there")
        return [self.value(depth + 1) for _ in range(count)]

    def map(self, count: int, depth: int) -> dict[Any, Any]:
        if 2 * count > len(self.data) - self.at:
            raise NotMessagePack(f"{count} pairs announced at byte {self.at}, {len(self.data) - self.at} bytes there")
        pairs = {}
        for _ in range(count):
            key = self.value(depth + 1)
            if not isinstance(key, (str, int)):
                raise NotMessagePack(f"a key before byte {self.at} that is neither text nor number")
            pairs[key] = self.value(depth + 1)
        return pairs


def unpack(data: bytes) -> Any:
    """The one value of these bytes; raises `NotMessagePack` for anything else."""
    unpacker = _Unpacker(data)
    value = unpacker.value()
    if unpacker.at != len(data):
        raise NotMessagePack(f"{len(data) - unpacker.at} bytes behind the value")
    return value
