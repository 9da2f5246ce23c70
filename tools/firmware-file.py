#!/usr/bin/env python3
"""Makes or shows a file for a firmware update over FoE (firmware/update.h).

usage: firmware-file.py IMAGE.bin ADDRESS EEPROM FILE [VERSION]   makes FILE
       firmware-file.py FILE                                      shows its header, and verifies it

IMAGE.bin   a firmware
ADDRESS     address that IMAGE.bin is linked for
EEPROM      content of the EEPROM of the product, as `ectwin sii DEVICE -o EEPROM` writes it: vendor ID and product code; a board
            refuses the file of another product
VERSION     a number of 32 bits; by default the revision number of EEPROM
"""
import struct
import sys
import zlib

HEADER = struct.Struct("<4sIIIIIII")
MAGIC, CHECKED_FROM = b"ETF2", 12
IDENTITY = struct.Struct("<III") # vendor, product, revision, in an EEPROM from byte 16 on


def read(path):
    try:
        with open(path, "rb") as source:
            return source.read()
    except OSError as error:
        sys.exit(f"cannot read '{path}': {error.strerror}")


def identity_of(path):
    eeprom = read(path)
    if len(eeprom) < 128 or eeprom[16:20] == b"\0\0\0\0":
        sys.exit(f"'{path}' is no content of an EEPROM, for it has no vendor ID: write one with ectwin sii DEVICE -o FILE")
    return IDENTITY.unpack_from(eeprom, 16)


def make(image, address, eeprom, path, version=None):
    content = read(image)
    vendor, product, revision = identity_of(eeprom)
    number = revision if version is None else int(version, 0)
    rest = struct.pack("<IIIII", int(address, 0), vendor, product, number, 0) + content
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", MAGIC, len(content), zlib.crc32(rest)) + rest)


def show(path):
    content = read(path)
    if len(content) < HEADER.size or content[:4] != MAGIC:
        sys.exit(f"'{path}' is no firmware file, for it does not begin with {MAGIC.decode()}: make one with firmware-file.py")
    _, length, check, address, vendor, product, version, _ = HEADER.unpack_from(content)
    print(f"vendor 0x{vendor:08X} product 0x{product:08X} version 0x{version:08X}, {length} bytes for address 0x{address:08X}")
    if len(content) != HEADER.size + length or zlib.crc32(content[CHECKED_FROM:]) != check:
        sys.exit("damaged: length or CRC-32 do not match")


def main():
    arguments = sys.argv[1:]
    if len(arguments) == 1 and not arguments[0].startswith("-"):
        show(arguments[0])
    elif len(arguments) in (4, 5):
        make(*arguments)
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
